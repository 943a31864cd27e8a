// A weighted mean of values that come one by one.
#pragma once

#include <algorithm>

namespace tetfusion {

// `before` is the weight of what the mean is of. Never outside of the values, by rounding neither,
// so that what is the same everywhere stays so.
inline void add_to_mean(double value, double weight, double before, double* mean) {
  if (!(before > 0)) {
    *mean = value;
    return;
  }
  const double share = weight / (before + weight);
  const auto [low, high] = std::minmax(*mean, value);
  *mean = std::clamp((1 - share) * *mean + share * value, low, high);
}

}  // namespace tetfusion
