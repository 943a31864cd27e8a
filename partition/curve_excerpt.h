// An excerpt of a mesh that is known by its points' places on a curve: windows of the curve, spread
// evenly over the points.
#pragma once

#include <cstdint>
#include <utility>

#include "base/vector.h"

namespace tetfusion {

class CurveExcerpt {
 public:
  CurveExcerpt() = default;  // nothing
  // One in kShare of `points`, in windows of about kWindow, but at most about `most`; though kFew,
  // or half of a mesh with fewer, and kLeastWindows smaller windows are always worth their memory.
  // `samples` are keys of some of the points, taken evenly, in any order.
  CurveExcerpt(std::uint64_t points, std::uint64_t most, Vector<std::uint64_t> samples);

  bool has(std::uint64_t key) const;

  static constexpr std::uint64_t kShare = 16;
  // In a window so large half of the points have all their neighbours beside them.
  static constexpr std::uint64_t kWindow = 512;
  static constexpr std::uint64_t kLeastWindows = 16;
  static constexpr std::uint64_t kFew = 2048;

 private:
  Vector<std::pair<std::uint64_t, std::uint64_t>> windows_;  // first and last keys, ascending
};

}  // namespace tetfusion
