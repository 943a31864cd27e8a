#include "driver/rounds/thresholds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

namespace tetfusion {
namespace {

// So many vertices at each cost.
CostHistogram histogram(std::initializer_list<std::pair<double, std::uint64_t>> counts) {
  CostHistogram costs{};
  for (const auto& [cost, vertices] : counts) costs[cost_bin(cost)] += vertices;
  return costs;
}

// The end of the bin that a cost is in.
double above(double cost) { return cost_bin_end(cost_bin(cost)); }

TEST(Costs, BinsAreHalfAnOctave) {
  for (double cost = 1e-20; cost < 50; cost *= 1.07) {
    const std::size_t bin = cost_bin(cost);
    EXPECT_LT(cost, cost_bin_end(bin));
    EXPECT_GE(cost, cost_bin_end(bin - 1));
    EXPECT_NEAR(cost_bin_end(bin) / cost_bin_end(bin - 1), std::sqrt(2.0), 1e-12);
    EXPECT_EQ(cost_bin(cost_bin_end(bin)), bin + 1);
  }
}

TEST(Costs, BinsAtTheEndsTakeTheRest) {
  EXPECT_EQ(cost_bin(0), 0u);
  EXPECT_EQ(cost_bin(-1), 0u);
  EXPECT_EQ(cost_bin(std::nan("")), 0u);
  EXPECT_EQ(cost_bin(1e-300), 0u);
  EXPECT_EQ(cost_bin(1e30), kCostBins - 1);
}

TEST(NextThreshold, TheFirstTakesHalfOfTheVertices) {
  const CostHistogram costs = histogram({{1e-6, 40}, {1e-4, 60}});
  EXPECT_EQ(next_threshold(costs, {}, {}), above(1e-4));
  EXPECT_EQ(next_threshold(histogram({{1e-6, 50}, {1e-4, 50}}), {}, {}), above(1e-6));
}

TEST(NextThreshold, ErrorsDoubleFromRoundToRound) {
  const CostHistogram costs = histogram({{1e-6, 60}, {1e-2, 40}});
  EXPECT_EQ(next_threshold(costs, {1e-5, false}, {}), 4e-5);
  EXPECT_EQ(next_threshold(costs, {1e-5, true}, {}), 4e-5);
  // Half of the vertices may be more.
  EXPECT_EQ(next_threshold(costs, {1e-7, false}, {}), above(1e-6));
}

TEST(NextThreshold, LessIsTakenWhereItIsEnough) {
  const CostHistogram costs = histogram({{1e-8, 30}, {1e-6, 30}, {1e-4, 100}});
  // 60 tetrahedra are 20 vertices that are counted.
  EXPECT_EQ(next_threshold(costs, {}, 60), above(1e-8));
  EXPECT_EQ(next_threshold(costs, {}, 0), above(1e-8));
  EXPECT_EQ(next_threshold(costs, {}, 120), above(1e-6));
  EXPECT_EQ(next_threshold(costs, {}, 300), above(1e-4));
  // Never more than what a round without a goal would take.
  EXPECT_EQ(next_threshold(costs, {}, 1'000'000), above(1e-4));
  EXPECT_EQ(next_threshold(histogram({{1e-8, 100}, {1, 10}}), {}, 315), above(1e-8));
}

TEST(NextThreshold, WhatWasNotEnoughIsNotEnoughNow) {
  const CostHistogram costs = histogram({{1e-8, 100}, {1e-4, 50}});
  EXPECT_EQ(next_threshold(costs, {1e-6, false}, 6), 2e-6);
  EXPECT_EQ(next_threshold(costs, {1e-6, true}, 6), above(1e-8));
  EXPECT_EQ(next_threshold(costs, {1e-6, true}, 400), 4e-6);
}

// The cheapest of them may be refused for ever.
TEST(NextThreshold, ALittleIsNotSoughtAmongTheCheapestAlone) {
  const CostHistogram costs = histogram({{1e-8, 5000}, {1e-4, 5000}});
  // What was left for the goal's sake is there; else whatever an ordinary round takes.
  EXPECT_EQ(next_threshold(costs, {1e-6, true}, 20), 1e-6);
  EXPECT_EQ(next_threshold(costs, {1e-6, false}, 20), 4e-6);
  // More than a thousandth of the vertices is no little.
  EXPECT_EQ(next_threshold(costs, {1e-6, true}, 60), above(1e-8));
  EXPECT_EQ(next_threshold(costs, {1e-6, false}, 60), 2e-6);
}

TEST(NextThreshold, AlwaysGoesOn) {
  for (const double last : {1e-12, 1e-6, 1.0}) {
    EXPECT_GE(next_threshold({}, {last, false}, {}), 2 * last);
    EXPECT_GE(next_threshold({}, {last, false}, 10), 2 * last);
    EXPECT_TRUE(std::isfinite(next_threshold({}, {last, false}, 10)));
  }
  EXPECT_GT(next_threshold({}, {}, {}), 0);
}

TEST(CostOfVariance, LiesBetweenTheFlatAndTheLastOnTheWay) {
  const CostHistogram costs = histogram({{1e-10, 60}, {1e-6, 30}, {1e-2, 10}});
  const double none = std::numeric_limits<double>::infinity();
  const auto between = [](double flat, double last) {
    return 4 * std::sqrt(above(flat) * above(last));
  };
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, {}, 0, none), between(1e-10, 1e-2));
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 6 * 85, 0, none), between(1e-10, 1e-6));
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 6 * 50, 0, none), 4 * above(1e-10));
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 1'000'000, 0, none), between(1e-10, 1e-2));
}

TEST(CostOfVariance, IsLessWhereOnlyLengthsCost) {
  const CostHistogram costs = histogram({{1e-10, 60}, {1e-8, 40}});
  const double none = std::numeric_limits<double>::infinity();
  const double flat = above(1e-10), last = above(1e-8);
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 6 * 90, last / 10, none), 4 * std::sqrt(flat * last));
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 6 * 90, last / 5, none), std::sqrt(flat * last) / 4);
  EXPECT_DOUBLE_EQ(cost_of_variance(costs, 6 * 50, last / 10, none), flat / 4);
}

TEST(CostOfVariance, IsNoMoreThanItMay) {
  const CostHistogram costs = histogram({{1e-6, 60}, {1e-2, 40}});
  for (const double most : {1e-12, 1e-8, 1e-5, 1e-3}) {
    EXPECT_LE(cost_of_variance(costs, {}, 0, most), most);
    EXPECT_LE(cost_of_variance(costs, 6 * 90, 0, most), most);
  }
  EXPECT_EQ(cost_of_variance(costs, {}, 0, 0), 0);
}

TEST(CostOfVariance, IsNothingWhereNothingCosts) {
  EXPECT_EQ(cost_of_variance({}, {}, 0, 1), 0);
  EXPECT_EQ(cost_of_variance({}, 600, 0, 1), 0);
}

TEST(LargestCost, IsAboveAll) {
  EXPECT_EQ(largest_cost({}), 0);
  EXPECT_EQ(largest_cost(histogram({{1e-9, 5}})), above(1e-9));
  EXPECT_EQ(largest_cost(histogram({{1e-9, 5}, {0.3, 1}, {1e-3, 7}})), above(0.3));
}

}  // namespace
}  // namespace tetfusion
