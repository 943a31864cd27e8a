// The cells of a mesh, range of vertices by range of vertices: what is round the vertices of a
// range can then be looked at by one thread, in its cache.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Ranges of kRangeVertices consecutive vertices. A cell is listed in the range of each of its
// vertices: once, if the vertices are near each other. 4 bytes each.
class CellsByRange {
 public:
  static constexpr VertexId kRangeVertices = 1 << 15;

  // Every id in `tets` must be below `vertices`. The result does not depend on the number of
  // threads.
  CellsByRange(std::size_t vertices, std::span<const Tet> tets);

  // Ascending.
  std::span<const TetId> of(std::size_t range) const {
    return {cells_.data() + offsets_[range], cells_.data() + offsets_[range + 1]};
  }

 private:
  Vector<std::uint64_t> offsets_;  // ranges + 1
  Vector<TetId> cells_;
};

}  // namespace tetfusion
