// The passes of scatter_mesh() that fill chunks, and what they share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/bit_set.h"
#include "driver/import/scatter.h"
#include "driver/rounds/memory_plan.h"
#include "partition/vertex_chunks.h"

namespace tetfusion {

template <class Real>
struct ScatterJob : ImportInput {
  const ScatterSettings& settings;
  const WorkMesh<Real>& layout;
  const RunContext& context;
  MemoryBudget* budget;
  std::uint32_t chunks = 1;
  VertexChunks table;  // of all chunks, and of the excerpt as number `chunks`
  BitSet excerpt;      // points of which an excerpt has all tetrahedra; empty: there is none
  InputWindow cell_window, point_window;
  std::uint32_t sampled = 0;  // the chunk that is a sample, as number 0

  std::uint32_t made_chunks() const {
    return settings.sample != nullptr ? 1 : chunks + (excerpt.empty() ? 0 : 1);
  }
  // What reading a window and sorting it takes: there are readers' buffers, too.
  MemoryBudget::Reservation wait_for(const InputWindow& window) const {
    constexpr std::uint64_t kLeast = std::uint64_t{48} << 20;
    return budget->wait_for(std::max(kLeast, window.bytes), "a window of the input");
  }
};

// The tetrahedra, to the chunks whose number is the lowest of their points'. Fills the table, and
// in *out the counts of cells and what there is of lower dimension.
template <class Real>
void scatter_cells(ScatterJob<Real>* job, PieceStore* to, ScatteredMesh<Real>* out);

// The points with their arrays, to the chunks that have tetrahedra of them. After scatter_cells().
// Fills in *out the counts of points, the box, and the loose points.
template <class Real>
void scatter_points(const ScatterJob<Real>& job, PieceStore* to, ScatteredMesh<Real>* out);

}  // namespace tetfusion
