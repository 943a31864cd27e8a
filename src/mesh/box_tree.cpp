#include "mesh/box_tree.h"

#include <cmath>

namespace tetfusion {

namespace {

float round_down(double x) {
  const auto f = static_cast<float>(x);
  return f <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

float round_up(double x) {
  const auto f = static_cast<float>(x);
  return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

}  // namespace

BoxTree::Box BoxTree::narrow(const PointBox& box) const {
  const Vec3<double> low = difference(box.low, origin_), high = difference(box.high, origin_);
  return {{round_down(low.x), round_down(low.y), round_down(low.z)},
          {round_up(high.x), round_up(high.y), round_up(high.z)}};
}

void BoxTree::begin_levels(std::size_t items) {
  levels_ = 0;
  std::size_t all = 0;
  for (std::size_t count = items; count > 0; count = (count + kFan - 1) / kFan) {
    begins_[levels_] = all;
    counts_[levels_++] = count;
    all += count;
    if (count <= kFan) break;
  }
  boxes_.resize(all);
}

void BoxTree::join_boxes(std::size_t level, std::size_t begin, std::size_t end) {
  const Box* below = boxes_.data() + begins_[level - 1];
  Box* boxes = boxes_.data() + begins_[level];
  for (std::size_t i = begin; i < end; ++i) {
    Box box = below[i * kFan];
    const std::size_t last = std::min(i * kFan + kFan, counts_[level - 1]);
    for (std::size_t child = i * kFan + 1; child < last; ++child) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], below[child].low[axis]);
        box.high[axis] = std::max(box.high[axis], below[child].high[axis]);
      }
    }
    boxes[i] = box;
  }
}

}  // namespace tetfusion
