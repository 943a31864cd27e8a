#include "compare/needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/numbers.h"
#include "compare/face_match.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

namespace {

// The program, its libraries, and what threads and allocators keep.
constexpr std::uint64_t kProcess = std::uint64_t{32} << 20;
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

// Of one array, as it is read.
std::uint64_t widest_row(const AttributeSet& set) {
  std::uint64_t widest = 0;
  for (const ArrayInfo& a : set.arrays) widest = std::max(widest, a.row_bytes());
  return widest;
}

// In a row, with lengths.
std::uint64_t point_values(const AttributeSet& set) { return components(set) + set.arrays.size(); }

// Of a compact body, as nobody has looked yet: of a cube of five tetrahedra a cell.
std::uint64_t guess_boundary(std::uint64_t tets) {
  return static_cast<std::uint64_t>(12 * std::pow(static_cast<double>(tets) / 5, 2.0 / 3.0));
}

// Of a mesh that cannot be read in windows.
std::uint64_t memory_to_hold(MeshSource* mesh) {
  const auto stream = mesh->stream();
  return stream ? stream->bytes() : mesh->memory_to_read();
}

}  // namespace

ComparisonNeeds estimate_comparison(const MeshDescription& original, std::uint64_t tets,
                                    std::uint64_t points, std::uint64_t boundary_triangles) {
  const std::uint64_t rows =
      sizeof(double) *
          (tets * components(original.cell_data) + points * point_values(original.point_data)) +
      std::max(tets * widest_row(original.cell_data), points * widest_row(original.point_data));
  const std::uint64_t all_sides = 4 * kSideBytes * original.cells;
  ComparisonNeeds needs;
  needs.fixed = kWindows + kTet * tets + kPoint * points + rows + kTriangle * boundary_triangles +
                original.points / kOriginalPointsPerByte;
  needs.least_sides =
      std::max(std::min(kLeastSideBytes, all_sides), kPointSumBytes * original.points);
  needs.most_sides = std::max(std::min(4 * kSideBytes * tets, all_sides), needs.least_sides);
  return needs;
}

std::uint64_t plan_comparison(MeshSource* original, MeshSource* simplified, std::uint64_t total) {
  const MeshDescription& before = original->description();
  const MeshDescription& after = simplified->description();
  const ComparisonNeeds needs =
      estimate_comparison(before, after.cells, after.points,
                          guess_boundary(before.cells) + guess_boundary(after.cells));
  const std::uint64_t held = kProcess + memory_to_hold(original) + memory_to_hold(simplified);
  const std::uint64_t least = held + needs.least();
  if (least > total) {
    throw Error(
        ErrorCode::kMemory,
        fmt::format("{} and {}: comparing these meshes needs about {} of memory, most of it "
                    "for the second, but it may use {}: give --memory {}M or more",
                    before.path, after.path, format_bytes(least), format_bytes(total),
                    (least >> 20) + 1));
  }
  return needs.sides_within(total - held);
}

}  // namespace tetfusion
