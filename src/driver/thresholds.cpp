#include "driver/thresholds.h"

#include <algorithm>

namespace tetfusion {

namespace {

// An error twice as large.
constexpr double kGrowth = 4;
// Of the vertices under a threshold half is gone when each of them has fused with another.
constexpr double kVerticesAFusion = 2;

// The cost that so many vertices do not exceed.
double quantile(const CostHistogram& costs, std::uint64_t vertices) {
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < kCostBins; ++bin) {
    below += costs[bin];
    if (below >= vertices) return cost_bin_end(bin);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

RoundThreshold next_threshold(const CostHistogram& costs, double previous,
                              std::optional<std::uint64_t> vertices_to_go) {
  std::uint64_t all = 0;
  for (const std::uint64_t count : costs) all += count;
  const double ordinary = std::max(kGrowth * previous, quantile(costs, (all + 1) / 2));
  if (!vertices_to_go) return {ordinary, false};
  const double enough = quantile(
      costs, static_cast<std::uint64_t>(kVerticesAFusion * static_cast<double>(*vertices_to_go)));
  if (enough <= ordinary) return {enough, true};
  return {ordinary, false};
}

}  // namespace tetfusion
