#include "mesh/inspection/boundary_sample.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/blocks.h"
#include "base/mix.h"

namespace tetfusion {

namespace {

std::uint64_t edge_hash(VertexId a, VertexId b) { return mix(edge_key(a, b)); }

}  // namespace

BoundarySample::BoundarySample(std::uint64_t points, std::uint64_t vertices)
    : points_(points), run_(std::max<std::uint64_t>(1, points / vertices)) {
  edges_.assign(block_count(points, run_), 0);
  used_.assign(edges_.size(), 0);
}

void BoundarySample::add(std::span<const Tet> tets) {
  std::atomic_ref(tets_).fetch_add(tets.size(), std::memory_order_relaxed);
  for (const Tet& t : tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint64_t run = t[k] / run_;
      // Its place in the run is drawn, as files often have a period.
      if (run_ > 1 && t[k] % run_ != mix(run) % run_) continue;
      const VertexId a = t[(k + 1) % 4], b = t[(k + 2) % 4], c = t[(k + 3) % 4];
      const std::uint64_t edges = edge_hash(a, b) ^ edge_hash(b, c) ^ edge_hash(c, a);
      std::atomic_ref(edges_[run]).fetch_xor(edges, std::memory_order_relaxed);
      std::atomic_ref(used_[run]).store(1, std::memory_order_relaxed);
    }
  }
}

BoundarySample::Counts BoundarySample::count() const {
  Counts counts;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    counts.used += used_[i];
    if (edges_[i] != 0) ++counts.boundary;
  }
  return counts;
}

std::uint64_t BoundarySample::used_points() const {
  if (run_ == 1) return count().used;
  const double share = static_cast<double>(count().used) / static_cast<double>(edges_.size());
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(points_) * share));
}

double BoundarySample::boundary_share() const {
  const Counts counts = count();
  if (counts.used == 0) return 0;
  return static_cast<double>(counts.boundary) / static_cast<double>(counts.used);
}

std::uint64_t BoundarySample::tets() const { return tets_; }

}  // namespace tetfusion
