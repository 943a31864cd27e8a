#include "base/progress.h"

#include <algorithm>
#include <cmath>

namespace tetfusion {

namespace {
constexpr double kLeastSeconds = 2;
constexpr double kLeastShare = 0.02;
constexpr double kSmoothingSeconds = 3;
}  // namespace

void ProgressEstimate::update(double share, double now) {
  share = share > 0 ? std::min(share, 1.0) : 0;
  if (!begun_) {
    begun_ = true;
    before_ = share;
    start_ = now;
    smoothed_at_ = now;
  }
  share_ = std::max(share_, share);
}

bool ProgressEstimate::can_say(double now) const {
  return now - start_ >= kLeastSeconds && done_here() >= kLeastShare && share_ < 1;
}

std::optional<double> ProgressEstimate::seconds_left(double now) {
  if (!can_say(now)) return std::nullopt;
  const double end = start_ + (now - start_) * (1 - before_) / done_here();
  // What is smoothed is when the run ends, so that the time left falls as the clock goes on.
  const double weight = 1 - std::exp(-(now - smoothed_at_) / kSmoothingSeconds);
  smoothed_end_ = smoothed_end_ ? *smoothed_end_ + weight * (end - *smoothed_end_) : end;
  smoothed_at_ = now;
  return std::max(0.0, *smoothed_end_ - now);
}

std::optional<double> ProgressEstimate::rate(std::uint64_t tets, double now) const {
  if (!can_say(now)) return std::nullopt;
  return static_cast<double>(tets) * done_here() / (now - start_);
}

}  // namespace tetfusion
