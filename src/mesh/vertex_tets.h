// The tetrahedra round each vertex, as one CSR: the only adjacency that passes keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// The entries of vertex v are entries[offsets[v]] up to entries[offsets[v + 1]], ascending. An
// entry is tet << 2 | corner, and tets[tet][corner] == v: a cell that names a vertex twice is there
// twice.
struct VertexTets {
  Vector<std::uint32_t> offsets;  // vertices + 1
  Vector<std::uint32_t> entries;  // 4 * tets

  std::span<const std::uint32_t> of(VertexId v) const {
    return {entries.data() + offsets[v], entries.data() + offsets[v + 1]};
  }
  std::span<std::uint32_t> of(VertexId v) {
    return {entries.data() + offsets[v], entries.data() + offsets[v + 1]};
  }
};

// Fills `out`, reusing its memory. Every id in `tets` must be below `vertices`, and there are at
// most kMaxTets of them. The result does not depend on the number of threads.
void build_vertex_tets(std::size_t vertices, std::span<const Tet> tets, VertexTets* out);

}  // namespace tetfusion
