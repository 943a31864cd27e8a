// The order of a few costs, found without a branch: which of two is lower cannot be foretold, and a
// sort of random numbers spends most of its time on guesses that were wrong.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include "base/lanes.h"

namespace tetfusion {

// Beyond so many, counting costs more than sorting.
inline constexpr std::size_t kMostCounted = 256;

// The same by sorting.
inline void sort_ranks(std::size_t count, const float* costs, std::int32_t* ranks) {
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return costs[a] < costs[b]; });
  for (std::size_t i = 0; i < count; ++i) ranks[order[i]] = static_cast<std::int32_t>(i);
}

// Gives each of `count` costs its rank in ascending order, those of equal ones as they come, by
// counting how many are before it, as there are dozens at most, but for odd vertices. None is
// infinite, or no number. Behind the costs, and behind the ranks, there is room for kLanes more.
inline void find_ranks(std::size_t count, float* costs, std::int32_t* ranks) {
  constexpr LaneMask kNumbers{0, 1, 2, 3};
  if (count > kMostCounted) return sort_ranks(count, costs, ranks);
  // Whole groups, as how many there are cannot be foretold well.
  std::fill_n(costs + count, kLanes, std::numeric_limits<float>::infinity());
  for (std::size_t own = 0; own < count; own += kLanes) {
    Lanes cost;
    std::memcpy(&cost, costs + own, sizeof cost);
    LaneMask rank{};
    for (std::size_t first = 0; first < own; first += kLanes) {
      for (std::size_t i = 0; i < kLanes; ++i) rank -= costs[first + i] <= cost;
    }
    for (std::size_t i = 0; i < kLanes; ++i) {
      const float other = costs[own + i];
      rank -= (other < cost) | ((other == cost) & (static_cast<std::int32_t>(i) < kNumbers));
    }
    for (std::size_t first = own + kLanes; first < count; first += kLanes) {
      for (std::size_t i = 0; i < kLanes; ++i) rank -= costs[first + i] < cost;
    }
    std::memcpy(ranks + own, &rank, sizeof rank);
  }
}

}  // namespace tetfusion
