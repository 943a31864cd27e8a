#include <algorithm>

#include "verify/verify.h"

namespace tetfusion {

namespace {

// Windows of the original, with their points and rows, and what is made of them.
constexpr std::uint64_t kWindows = std::uint64_t{32} << 20;
// The result while it is compared; to inspect it takes less.
constexpr std::uint64_t kTet = 74;
constexpr std::uint64_t kPoint = 64;
// Sides of triangles, while the original's boundary is looked for.
constexpr std::uint64_t kSides = std::uint64_t{64} << 20;
constexpr std::uint64_t kSidesOfTet = 128;
// Triangles with their points, of both surfaces, while distances are measured.
constexpr std::uint64_t kTriangle = 100;
// Bits of points: of those that are used, and of those of a window, with numbers.
constexpr std::uint64_t kOriginalPointsPerByte = 2;

std::uint64_t components(const AttributeSet& set) {
  std::uint64_t sum = 0;
  for (const ArrayInfo& a : set.arrays) sum += a.components;
  return sum;
}

}  // namespace

std::uint64_t estimate_verification(const MeshDescription& original, std::uint64_t tets,
                                    std::uint64_t points, std::uint64_t boundary_triangles) {
  const std::uint64_t rows = sizeof(double) * (tets * components(original.cell_data) +
                                               points * components(original.point_data));
  const std::uint64_t sides =
      std::min(std::max(kSides, kSidesOfTet * tets), kSidesOfTet * original.cells);
  return kWindows + sides + kTet * tets + kPoint * points + rows + kTriangle * boundary_triangles +
         original.points / kOriginalPointsPerByte;
}

}  // namespace tetfusion
