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
  // Of those from `begin` on and below `end`, for which there is room.
  std::uint64_t count(std::uint64_t begin, std::uint64_t end) const {
    std::uint64_t sum = 0;
    for (; begin < end && begin % 64 != 0; ++begin) sum += has(begin) ? 1 : 0;
    for (; begin + 64 <= end; begin += 64) {
      sum += static_cast<std::uint64_t>(std::popcount(words_[begin / 64]));
    }
    for (; begin < end; ++begin) sum += has(begin) ? 1 : 0;
    return sum;
  }
  std::uint64_t bytes() const { return words_.size() * sizeof(std::uint64_t); }

 private:
  static std::uint64_t bit(std::uint64_t i) { return std::uint64_t{1} << i % 64; }
  Vector<std::uint64_t> words_;
};

}  // namespace tetfusion
