// The passes of scatter_mesh() that fill chunks, and what they share.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "driver/memory_plan.h"
#include "driver/scatter.h"
#include "partition/vertex_chunks.h"

namespace tetfusion {

// The points of an excerpt. set() from several threads.
class ExcerptPoints {
 public:
  // From here on there is an excerpt.
  void resize(std::size_t points) { bits_.assign(points / 64 + 1, 0); }
  bool exists() const { return !bits_.empty(); }
  void set(VertexId v) {
    std::atomic_ref(bits_[v / 64]).fetch_or(std::uint64_t{1} << v % 64, std::memory_order_relaxed);
  }
  // Has the excerpt all tetrahedra of the point?
  bool has(VertexId v) const { return (bits_[v / 64] >> v % 64 & 1) != 0; }

 private:
  Vector<std::uint64_t> bits_;
};

template <class Real>
struct ScatterJob : ImportInput {
  const ScatterSettings& settings;
  const WorkMesh<Real>& layout;
  const RunContext& context;
  MemoryBudget* budget;
  std::uint32_t chunks = 1;
  VertexChunks table;  // of all chunks, and of the excerpt as number `chunks`
  ExcerptPoints excerpt;
  InputWindow cell_window, point_window;

  // A sample is the chunk in the middle, as number 0.
  bool is_sampled(std::uint32_t chunk) const { return chunk == chunks / 2; }
  std::uint32_t made_chunks() const {
    return settings.sample != nullptr ? 1 : chunks + (excerpt.exists() ? 1 : 0);
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
