// Boxes round points, in double precision.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "mesh/geometry.h"

namespace tetfusion {

struct PointBox {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  Vec3<double> low{kNone, kNone, kNone};
  Vec3<double> high{-kNone, -kNone, -kNone};

  bool empty() const { return low.x > high.x; }
  void add(const Vec3<double>& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const PointBox& box) {
    add(box.low);
    add(box.high);
  }
  Vec3<double> extent() const {
    if (empty()) return {};
    return {high.x - low.x, high.y - low.y, high.z - low.z};
  }
  Vec3<double> centre() const {
    if (empty()) return {};
    const Vec3<double> all = extent();
    return {low.x + 0.5 * all.x, low.y + 0.5 * all.y, low.z + 0.5 * all.z};
  }
};

inline PointBox box_of(std::span<const Vec3<double>> points) {
  PointBox box;
  for (const Vec3<double>& p : points) box.add(p);
  return box;
}

}  // namespace tetfusion
