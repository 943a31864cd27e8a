// The triangles of a mesh whose cells come in windows, without holding more than some of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Of a side while it is matched; and of as many as are always taken at once.
inline constexpr std::uint64_t kSideBytes = 16;
inline constexpr std::uint64_t kLeastSideBytes = std::uint64_t{64} << 20;
// Of a point while find_single_sides() looks for what it needs to match.
inline constexpr std::uint64_t kPointSumBytes = 8;

// How many sides at once take no more memory than that, or kLeastSideBytes.
inline std::size_t sides_within(std::uint64_t bytes) {
  return std::max(bytes, kLeastSideBytes) / kSideBytes;
}

// One cell's side of a triangle. The corners ascend.
struct CellSide {
  VertexId low, middle, high;
  std::uint32_t side;  // 4 * cell (or its label) + the corner opposite to it, modulo 2^32
};

struct CellRun {
  std::uint64_t first = 0;  // number of the first cell
  std::span<const Tet> tets;
  std::span<const std::uint32_t> labels = {};  // one a cell, that sides have instead of its number
};

// Calls take(run) for runs of cells that cover the mesh, in order.
using ReadCells = std::function<void(const std::function<void(const CellRun& run)>& take)>;

// Called with all sides of a triangle, ascending by side. From several threads, for different
// triangles.
using JudgeFace = std::function<bool(std::span<const CellSide>)>;

// Finds all triangles of a mesh with `points` points and returns the first side of each for which
// `keep` returned true, ascending by corners. Cells that name a vertex twice have no triangles.
// About `most_sides` sides are in memory at once, 16 bytes each; the cells are read once, and once
// more for each range of vertices with so many.
Vector<CellSide> match_faces(std::uint64_t points, std::size_t most_sides, const ReadCells& read,
                             const JudgeFace& keep);

// The sides that are alone on their triangle, in the same order: the boundary. Sides are held only
// of triangles whose smallest vertex has a triangle with an odd number of them, and the cells are
// read once more, which takes 8 bytes a point. A vertex on the boundary is overlooked with a chance
// of 2^-64.
Vector<CellSide> find_single_sides(std::uint64_t points, std::size_t most_sides,
                                   const ReadCells& read);

}  // namespace tetfusion
