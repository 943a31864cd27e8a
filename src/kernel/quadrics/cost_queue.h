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
// a bin, first come, first served. Vertices with neighbouring ids are a block, and each block has
// bins of its own: whoever works on one block for a while finds most of it in the processor's
// caches. Keeps its memory from mesh to mesh.
class CostQueue {
 public:
  static constexpr std::size_t kBins = 1 << 11;
  static std::size_t bin_of(float cost) {
    return cost > 0 ? std::bit_cast<std::uint32_t>(cost) >> 20 : 0;
  }

  void reset(std::size_t vertices) {
    at_.assign(vertices / kBlock + 1, 0);
    first_.assign(at_.size() * kBins, kNoVertex);
    last_.assign(at_.size() * kBins, kNoVertex);
    next_.resize(vertices);
    waits_.assign(vertices, 0);
  }
  std::size_t blocks() const { return at_.size(); }
  static std::size_t block_of(VertexId v) { return v / kBlock; }

  // Where the block is from now on: it is that bin's turn, and whoever comes waits there or further
  // on. Who waits in a bin that was passed over does so until the block goes back.
  void go_to(std::size_t block, std::size_t bin) { at_[block] = bin; }

  // Into the bin of its cost, or the one where its block is. A vertex that waits already stays
  // where it is.
  void push(VertexId v, float cost) {
    if (waits_[v] != 0) return;
    const std::size_t block = v / kBlock;
    const std::size_t bin = block * kBins + std::max(bin_of(cost), at_[block]);
    waits_[v] = 1;
    next_[v] = kNoVertex;
    (first_[bin] == kNoVertex ? first_[bin] : next_[last_[bin]]) = v;
    last_[bin] = v;
  }

  // Of the bin where the block is. kNoVertex: nobody waits there.
  VertexId pop(std::size_t block) {
    const VertexId v = first(block);
    if (v == kNoVertex) return v;
    first_[block * kBins + at_[block]] = next_[v];
    waits_[v] = 0;
    return v;
  }
  // Who comes next, and after that one.
  VertexId first(std::size_t block) const { return first_[block * kBins + at_[block]]; }
  VertexId after(VertexId v) const { return next_[v]; }

 private:
  // Some 6,000 tetrahedra: a quarter of a mebibyte of what a fusion looks at.
  static constexpr std::size_t kBlock = 1024;

  Vector<std::size_t> at_;         // the bin where each block is
  Vector<VertexId> first_, last_;  // of a block's bin
  Vector<VertexId> next_;          // in the same bin
  Vector<std::uint8_t> waits_;
};

}  // namespace tetfusion
