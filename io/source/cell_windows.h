// The cells of a window, as a file lists them, sorted into tetrahedra and cells of lower dimension.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "io/source/mesh_stream.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Tetrahedra, triangles, lines, vertices; and what is left out (kLeftOut).
struct MixedCells {
  std::uint64_t first = 0;              // row of the first one
  std::span<const std::uint8_t> types;  // VTK's
  std::span<const std::uint64_t> ends;  // one entry more: where the ids of each begin and end
  std::span<const VertexId> ids;        // those from ends[0] on
};

// Empties it; its memory stays, for the next window.
void clear(CellWindow* window);

// The lowest vertex of its cells of which is_wanted(v) holds; kNoVertex: of none.
template <class F>
VertexId lowest_vertex(const CellWindow& window, F is_wanted) {
  VertexId lowest = kNoVertex;
  const auto look = [&](VertexId v) {
    if (is_wanted(v)) lowest = std::min(lowest, v);
  };
  for (const Tet& tet : window.tets) std::for_each(tet.begin(), tet.end(), look);
  std::for_each(window.lower.connectivity.begin(), window.lower.connectivity.end(), look);
  return lowest;
}

// Fills an empty window, but for its ghost_cells.
void sort_cells(const MixedCells& cells, CellWindow* out);

}  // namespace tetfusion
