#include "partition/curve_excerpt.h"

#include <algorithm>

namespace tetfusion {

CurveExcerpt::CurveExcerpt(std::uint64_t points, std::uint64_t most,
                           Vector<std::uint64_t> samples) {
  if (samples.empty()) return;
  std::sort(samples.begin(), samples.end());
  const std::uint64_t wanted =
      std::clamp(points / kShare, std::min(points / 2, kFew), std::max(most, kFew));
  const std::uint64_t windows = std::max(wanted / kWindow, kLeastWindows);
  const std::uint64_t all = samples.size();
  const std::uint64_t in_one = wanted * all / (points * windows);
  // In the middle of its part of the curve.
  for (std::uint64_t w = 0; w < windows; ++w) {
    const std::uint64_t begin = (2 * w + 1) * all / (2 * windows) - in_one / 2;
    windows_.emplace_back(samples[begin], samples[std::min(begin + in_one, all - 1)]);
  }
}

bool CurveExcerpt::has(std::uint64_t key) const {
  const auto after = std::upper_bound(windows_.begin(), windows_.end(), key,
                                      [](std::uint64_t k, const auto& w) { return k < w.first; });
  return after != windows_.begin() && key <= std::prev(after)->second;
}

}  // namespace tetfusion
