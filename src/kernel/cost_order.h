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

// The same by sorting, of costs that are numbers.
inline void sort_places(std::size_t count, const float* costs, std::int32_t* places) {
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return costs[a] < costs[b]; });
  for (std::size_t i = 0; i < count; ++i) places[order[i]] = static_cast<std::int32_t>(i);
}

// Gives each of `count` costs its place in ascending order, those of equal ones as they come, by
// counting how many are before it, as there are dozens at most, but for odd vertices. What is no
// number becomes infinite, and so comes last. Behind the costs, and behind the places, there is
// room for kLanes more.
inline void find_places(std::size_t count, float* costs, std::int32_t* places) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr LaneMask kNumbers{0, 1, 2, 3};
  for (std::size_t i = 0; i < count; ++i) costs[i] = costs[i] < kInfinity ? costs[i] : kInfinity;
  if (count > kMostCounted) return sort_places(count, costs, places);
  for (std::size_t first = 0; first < count; first += kLanes) {
    Lanes own;
    std::memcpy(&own, costs + first, sizeof own);
    const std::size_t end = std::min(first + kLanes, count);
    LaneMask place{};
    for (std::size_t j = 0; j < first; ++j) place -= costs[j] <= own;
    for (std::size_t j = first; j < end; ++j) {
      const auto number = static_cast<std::int32_t>(j - first);
      place -= (costs[j] < own) | ((costs[j] == own) & (number < kNumbers));
    }
    for (std::size_t j = end; j < count; ++j) place -= costs[j] < own;
    std::memcpy(places + first, &place, sizeof place);
  }
}

}  // namespace tetfusion
