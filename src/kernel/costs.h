// What the cheapest fusion of each vertex costs, counted.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace tetfusion {

// Two bins an octave. Costs are squared errors, as shares of a field's range.
inline constexpr std::size_t kCostBins = 160;
using CostHistogram = std::array<std::uint64_t, kCostBins>;
inline constexpr int kLeastCostExponent = -72;

// The first and the last bin take all that is below or above.
inline std::size_t cost_bin(double cost) {
  if (!(cost > 0)) return 0;
  int exponent = 0;
  const double fraction = std::frexp(cost, &exponent);
  const int bin =
      2 * (exponent - kLeastCostExponent) + (fraction >= 0.5 * std::numbers::sqrt2 ? 1 : 0);
  return static_cast<std::size_t>(std::clamp(bin, 0, static_cast<int>(kCostBins) - 1));
}

// Costs in the bin are below it.
inline double cost_bin_end(std::size_t bin) {
  const int exponent = static_cast<int>(bin / 2) + kLeastCostExponent;
  return std::ldexp(bin % 2 == 0 ? 0.5 * std::numbers::sqrt2 : 1.0, exponent);
}

}  // namespace tetfusion
