// Some of the numbers from 0 on, a bit each.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <functional>
#include <numeric>

#include "base/vector.h"

namespace tetfusion {

class BitSet {
 public:
  // Room for the numbers below `size`, of which none is in the set.
  void resize(std::uint64_t size) { words_.assign(size / 64 + 1, 0); }
  bool empty() const { return words_.empty(); }  // has no room

  // There is room for i.
  void set(std::uint64_t i) { words_[i / 64] |= bit(i); }
  // The same from several threads at once.
  void set_atomically(std::uint64_t i) {
    std::atomic_ref(words_[i / 64]).fetch_or(bit(i), std::memory_order_relaxed);
  }
  // There is room for i, or for nothing.
  bool has(std::uint64_t i) const { return !empty() && (words_[i / 64] & bit(i)) != 0; }

  std::uint64_t count() const {  // of those in the set
    return std::transform_reduce(words_.begin(), words_.end(), std::uint64_t{0}, std::plus<>(),
                                 [](std::uint64_t w) { return std::uint64_t(std::popcount(w)); });
  }
  std::uint64_t bytes() const { return words_.size() * sizeof(std::uint64_t); }

 private:
  static std::uint64_t bit(std::uint64_t i) { return std::uint64_t{1} << i % 64; }
  Vector<std::uint64_t> words_;
};

}  // namespace tetfusion
