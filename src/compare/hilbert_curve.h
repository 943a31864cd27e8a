// An order of points in which what comes next lies near.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "compare/point.h"
#include "mesh/hilbert.h"

namespace tetfusion {

// Hilbert's curve through a box.
class HilbertCurve {
 public:
  static constexpr int kAxisBits = 10;

  explicit HilbertCurve(const PointBox& box) : low_(box.low) {  // not empty
    const auto steps_in = [](double extent) {
      const double steps = (1 << kAxisBits) / extent;
      return std::isfinite(steps) ? steps : 0;
    };
    const Point extent = box.extent();
    steps_ = {steps_in(extent.x), steps_in(extent.y), steps_in(extent.z)};
  }

  // Of 3 * kAxisBits bits.
  std::uint32_t key(const Point& p) const {
    return static_cast<std::uint32_t>(
        hilbert_key(step((p.x - low_.x) * steps_.x), step((p.y - low_.y) * steps_.y),
                    step((p.z - low_.z) * steps_.z), kAxisBits));
  }

 private:
  static std::uint32_t step(double x) {
    constexpr double kLast = (1 << kAxisBits) - 1;
    return static_cast<std::uint32_t>(std::min(std::max(0.0, x), kLast));
  }

  Point low_;
  Point steps_;  // in the unit of length
};

}  // namespace tetfusion
