// Which cells of a mesh that folds over itself are the inverted ones.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>

#include "base/vector.h"

namespace tetfusion {

// Sets of whole numbers. One thread; UnionFind is for several.
class DisjointSets {
 public:
  void reset(std::size_t size) {
    parent_.clear();
    grow(size);
  }
  void grow(std::size_t size) {
    const std::size_t old_size = parent_.size();
    parent_.resize(size);
    std::iota(parent_.begin() + static_cast<std::ptrdiff_t>(old_size), parent_.end(),
              static_cast<std::uint32_t>(old_size));
  }
  // The smallest of the set.
  std::uint32_t find(std::uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  void unite(std::uint32_t a, std::uint32_t b) { unite_root(find(a), b); }
  // The same for a root; returns the root of both.
  std::uint32_t unite_root(std::uint32_t root, std::uint32_t x) {
    if (parent_[x] == root) return root;
    const std::uint32_t other = find(x);
    const std::uint32_t low = std::min(root, other);
    parent_[root] = parent_[other] = parent_[x] = low;
    return low;
  }

 private:
  Vector<std::uint32_t> parent_;
};

// Cells that are connected by faces which two cells share from both sides: all of them are inverted
// or none is. At a fold-over face one cluster ends and another one, wound against it, begins.
struct Cluster {
  std::uint64_t cells = 0;
  std::uint64_t rewound = 0;                                        // of them
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max();  // the smallest cell id

  void add(const Cluster& other) {
    cells += other.cells;
    rewound += other.rewound;
    first = std::min(first, other.first);
  }
};

// Two clusters that meet at a fold-over face.
using Fold = std::array<std::uint32_t, 2>;

// 1 for each inverted cluster. Clusters connected by folds have two colours, which change at every
// fold; the colour of fewer cells is the inverted one, of two that are as many the one with more
// cells that had to be rewound, then the one without the first cell. The order of clusters and
// folds does not matter, only the first cells do.
Vector<std::uint8_t> find_inverted_clusters(std::span<const Cluster> clusters,
                                            std::span<const Fold> folds);

}  // namespace tetfusion
