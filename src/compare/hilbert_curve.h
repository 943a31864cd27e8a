// An order of points in which what comes next lies near.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "compare/point.h"
#include "mesh/hilbert.h"

namespace tetfusion {

// Hilbert's curve through a box, which is not empty, with so many bits an axis: an even number.
class HilbertCurve {
 public:
  static constexpr int kMostBits = 10;

  explicit HilbertCurve(const PointBox& box, int bits = kMostBits)
      : bits_(bits), last_((1 << bits) - 1), low_(box.low) {
    const auto steps_in = [&](double extent) {
      const double steps = (last_ + 1) / extent;
      return std::isfinite(steps) ? steps : 0;
    };
    const Point extent = box.extent();
    steps_ = {steps_in(extent.x), steps_in(extent.y), steps_in(extent.z)};
  }

  int key_bits() const { return 3 * bits_; }
  std::uint32_t key(const Point& p) const {
    return static_cast<std::uint32_t>(hilbert_key(step((p.x - low_.x) * steps_.x),
                                                  step((p.y - low_.y) * steps_.y),
                                                  step((p.z - low_.z) * steps_.z), bits_));
  }

 private:
  std::uint32_t step(double x) const {
    return static_cast<std::uint32_t>(std::min(std::max(0.0, x), last_));
  }

  int bits_;
  double last_;
  Point low_;
  Point steps_;  // in the unit of length
};

}  // namespace tetfusion
