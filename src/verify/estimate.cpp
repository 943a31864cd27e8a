#include <algorithm>

#include "compare/face_match.h"
#include "verify/verify.h"

namespace tetfusion {

namespace {

// Windows of the original, with their points and rows, and what is made of them.
constexpr std::uint64_t kWindows = std::uint64_t{32} << 20;
// The result while it is compared; to inspect it takes less.
constexpr std::uint64_t kTet = 74;
constexpr std::uint64_t kPoint = 64;
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

VerificationNeeds estimate_verification(const MeshDescription& original, std::uint64_t tets,
                                        std::uint64_t points, std::uint64_t boundary_triangles) {
  const std::uint64_t rows = sizeof(double) * (tets * components(original.cell_data) +
                                               points * components(original.point_data));
  const std::uint64_t all_sides = 4 * kSideBytes * original.cells;
  VerificationNeeds needs;
  needs.fixed = kWindows + kTet * tets + kPoint * points + rows + kTriangle * boundary_triangles +
                original.points / kOriginalPointsPerByte;
  needs.least_sides = std::min(kLeastSideBytes, all_sides);
  needs.most_sides = std::min(std::max(kLeastSideBytes, 4 * kSideBytes * tets), all_sides);
  return needs;
}

}  // namespace tetfusion
