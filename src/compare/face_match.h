// The triangles of a mesh whose cells come in windows, without holding more than some of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// One cell's side of a triangle. The corners ascend.
struct CellSide {
  VertexId low, middle, high;
  std::uint32_t side;  // 4 * cell + the corner opposite to it, modulo 2^32
};

// Calls take(first, tets) for windows that cover the mesh, in order; `first` is the number of the
// window's first cell.
using ReadCells = std::function<void(
    const std::function<void(std::uint64_t first, std::span<const Tet> tets)>& take)>;

// Called with all sides of a triangle, ascending by side. From several threads, for different
// triangles.
using JudgeFace = std::function<bool(std::span<const CellSide>)>;

// Finds all triangles of a mesh with `points` points and returns the first side of each for which
// `keep` returned true, ascending by corners. Cells that name a vertex twice have no triangles.
// About `most_sides` sides are in memory at once, 32 bytes each; the cells are read once, and once
// more for each range of vertices with so many.
Vector<CellSide> match_faces(std::uint64_t points, std::size_t most_sides, const ReadCells& read,
                             const JudgeFace& keep);

}  // namespace tetfusion
