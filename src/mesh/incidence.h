// The counting sort behind every "what is round a vertex" list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// CSR of vertex -> corners: corner k of cell i is entry K * i + k; those of vertex v are
// entries[offsets[v]] up to entries[offsets[v + 1]], ascending. All ids are below `vertices`, and
// the corners are countable in 32 bits.
template <std::size_t K>
void build_incidence(std::size_t vertices, std::span<const std::array<VertexId, K>> cells,
                     Vector<std::uint32_t>* offsets, Vector<std::uint32_t>* entries) {
  offsets->assign(vertices + 1, 0);
  entries->resize(cells.size() * K);
  // cursor[v] counts, then says where the next entry of v goes. It lies one place ahead of offsets,
  // so that it has become offsets when all entries are placed.
  std::uint32_t* cursor = offsets->data() + 1;
  for (const auto& cell : cells) {
    for (const VertexId v : cell) ++cursor[v];
  }
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const std::uint32_t count = cursor[v];
    cursor[v] = begin;
    begin += count;
  }
  std::uint32_t* const out = entries->data();
  std::uint32_t entry = 0;
  for (const auto& cell : cells) {
    for (const VertexId v : cell) out[cursor[v]++] = entry++;
  }
}

}  // namespace tetfusion
