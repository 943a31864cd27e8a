#include "driver/rounds/thresholds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tetfusion {

namespace {

// From round to round: an error twice as large. Larger steps let chunks run ahead of what lies
// between them.
constexpr double kGrowth = 4;
// A fusion takes about six tetrahedra, and two of the vertices that are counted.
constexpr double kVerticesATet = 2.0 / 6;

// Where fewer of the vertices have to go the cheapest may all be some that are refused again and
// again: what was left for the goal's sake in the last round goes, or whatever does not cost more
// than in any other round.
constexpr double kLittle = 1e-3;

constexpr double kFusionsATet = 1.0 / 6;
// A quarter takes a tenth more time, as more fusions are refused, for the same errors: what it does
// to them to have short edges go first is made good in the end (kernel/fit). But where fields do
// not bend at all on the way to the goal it would be all the error that there is.
constexpr double kVarianceShare = 4, kVarianceShareUnbent = 0.25;
// A long edge costs so much more than a typical one, by its length.
constexpr double kLongEdge = 8;

// The cost that so many vertices do not exceed.
double quantile(const CostHistogram& costs, double vertices) {
  double below = 0;
  for (std::size_t bin = 0; bin < kCostBins; ++bin) {
    below += static_cast<double>(costs[bin]);
    if (below >= vertices) return cost_bin_end(bin);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

double next_threshold(const CostHistogram& costs, const Threshold& last,
                      std::optional<std::uint64_t> tets_to_go) {
  const auto all = static_cast<double>(std::accumulate(costs.begin(), costs.end(), 0ULL));
  const double ordinary = std::max(kGrowth * last.cost, quantile(costs, all / 2));
  if (!tets_to_go) return ordinary;
  const double vertices = kVerticesATet * static_cast<double>(*tets_to_go) + 1;
  const double enough = quantile(costs, vertices);
  const bool is_little = vertices < kLittle * all;
  // What was not enough for all that the last round had to do is not enough now.
  double least = last.quota_was_met ? 0 : 2 * last.cost;
  if (is_little) least = last.quota_was_met ? last.cost : ordinary;
  return std::clamp(enough, std::min(least, ordinary), ordinary);
}

double cost_of_variance(const CostHistogram& costs, std::optional<std::uint64_t> tets_to_go,
                        double length_cost, double most) {
  const auto all = static_cast<double>(std::accumulate(costs.begin(), costs.end(), 0ULL));
  double last = std::min(largest_cost(costs), most);
  if (tets_to_go) {
    last = std::min(last, quantile(costs, kFusionsATet * static_cast<double>(*tets_to_go)));
  }
  const double flat = std::min(quantile(costs, all / 2), last);
  const double share = last > kLongEdge * length_cost ? kVarianceShare : kVarianceShareUnbent;
  return std::min(share * std::sqrt(flat * last), most);
}

double largest_cost(const CostHistogram& costs) {
  for (std::size_t bin = kCostBins; bin-- > 0;) {
    if (costs[bin] > 0) return cost_bin_end(bin);
  }
  return 0;
}

}  // namespace tetfusion
