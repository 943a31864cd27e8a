// Vertices that wait for their turn, the cheapest first.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Bins of costs, eight an octave: a float's exponent, and the first three bits of its fraction. In
// a bin, first come, first served. Keeps its memory from mesh to mesh.
class CostQueue {
 public:
  static constexpr std::size_t kBins = 1 << 11;
  static std::size_t bin_of(float cost) {
    return cost > 0 ? std::bit_cast<std::uint32_t>(cost) >> 20 : 0;
  }

  void reset(std::size_t vertices) {
    first_.assign(kBins, kNoVertex);
    last_.assign(kBins, kNoVertex);
    next_.resize(vertices);
    waits_.assign(vertices, 0);
  }

  // Into the bin of its cost, or the first bin from which on somebody may still wait. A vertex that
  // waits already stays where it is.
  void push(VertexId v, float cost, std::size_t first_bin) {
    if (waits_[v] != 0) return;
    const std::size_t bin = std::max(bin_of(cost), first_bin);
    waits_[v] = 1;
    next_[v] = kNoVertex;
    (first_[bin] == kNoVertex ? first_[bin] : next_[last_[bin]]) = v;
    last_[bin] = v;
  }

  // kNoVertex: nobody waits there.
  VertexId pop(std::size_t bin) {
    const VertexId v = first_[bin];
    if (v == kNoVertex) return v;
    first_[bin] = next_[v];
    waits_[v] = 0;
    return v;
  }

 private:
  Vector<VertexId> first_, last_;  // of a bin
  Vector<VertexId> next_;          // in the same bin
  Vector<std::uint8_t> waits_;
};

}  // namespace tetfusion
