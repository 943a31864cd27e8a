#include "kernel/quadrics/cost_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace tetfusion {
namespace {

// Few different ones, so that many are equal.
std::vector<float> some_costs(std::size_t count, std::mt19937* random) {
  std::vector<float> costs;
  for (std::size_t i = 0; i < count; ++i) costs.push_back(static_cast<float>((*random)() % 7));
  return costs;
}

TEST(CostOrder, IsThatOfAStableSort) {
  std::mt19937 random(1);
  for (std::size_t run = 0; run < 500; ++run) {
    const std::size_t count = run % 100 == 99 ? kMostCounted - 2 + run / 100 : run % 45;
    const std::vector<float> costs = some_costs(count, &random);
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
    std::vector<float> padded = costs;
    padded.resize(count + kLanes, -1.0F);  // what is behind them counts for nothing
    std::vector<std::int32_t> ranks(count + kLanes);
    find_ranks(count, padded.data(), ranks.data());
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(ranks[order[i]], static_cast<std::int32_t>(i));
    }
  }
}

}  // namespace
}  // namespace tetfusion
