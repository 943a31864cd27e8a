// Which of many boxes hold a point, and which items lie nearest to it: a tree of boxes in flat
// arrays, eight children a node, over items whose order keeps neighbours together.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/blocks.h"
#include "base/vector.h"
#include "mesh/point_box.h"
#include "mesh/vectors.h"

namespace tetfusion {

// Const functions may be called from several threads.
class BoxTree {
 public:
  // box_of(item) is the PointBox of each of `items` items, fewer than 2^32; it is called from
  // several threads.
  template <class BoxOf>
  void build(std::size_t items, const Vec3<double>& origin, BoxOf box_of) {
    origin_ = origin;
    begin_levels(items);
    for_each_block(items, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) boxes_[i] = narrow(box_of(i));
    });
    for (std::size_t level = 1; level < levels_; ++level) {
      for_each_block(counts_[level], kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        join_boxes(level, begin, end);
      });
    }
  }
  // The same on the calling thread alone.
  template <class BoxOf>
  void build_alone(std::size_t items, const Vec3<double>& origin, BoxOf box_of) {
    origin_ = origin;
    begin_levels(items);
    for (std::size_t i = 0; i < items; ++i) boxes_[i] = narrow(box_of(i));
    for (std::size_t level = 1; level < levels_; ++level) join_boxes(level, 0, counts_[level]);
  }
  void clear() { levels_ = 0; }

  bool empty() const { return levels_ == 0; }
  // Bytes that it takes.
  static constexpr std::uint64_t memory(std::uint64_t items) {
    return (items * kFan / (kFan - 1) + kDepth) * sizeof(Box);
  }

  // Calls accept(item) for the items whose boxes, larger by `margin` on all sides, hold the point,
  // in ascending order, until it returns true. Returns whether it did.
  template <class F>
  bool find(const Vec3<double>& p, double margin, F accept) const {
    if (empty()) return false;
    const Vec3<double> at = difference(p, origin_);
    std::array<Node, kDepth * kFan> stack;
    std::size_t size = 0;
    push_level_above(&stack, &size);
    while (size > 0) {
      const Node node = stack[--size];
      if (node.level == 0) {
        if (accept(node.index)) return true;
        continue;
      }
      const std::size_t first = std::size_t{node.index} * kFan;
      const std::uint32_t below = node.level - 1;
      const std::size_t last = std::min(first + kFan, counts_[below]);
      for (std::size_t child = last; child > first; --child) {
        if (!holds(boxes_[begins_[below] + child - 1], at, margin)) continue;
        stack[size++] = {below, static_cast<std::uint32_t>(child - 1), 0};
      }
    }
    return false;
  }

  // Calls measure(item), which returns the square of the item's distance from the point, for items
  // that may be nearer than *squared, which becomes the least.
  template <class F>
  void find_nearest(const Vec3<double>& p, double* squared, F measure) const {
    if (empty()) return;
    const Vec3<double> at = difference(p, origin_);
    std::array<Node, kDepth * kFan> stack;
    std::size_t size = 0;
    push_level_above(&stack, &size);
    while (size > 0) {
      const Node node = stack[--size];
      if (node.squared >= *squared) continue;
      if (node.level == 0) {
        *squared = std::min(*squared, measure(node.index));
        continue;
      }
      const std::size_t before = size;
      const std::size_t first = std::size_t{node.index} * kFan;
      const std::uint32_t below = node.level - 1;
      const std::size_t last = std::min(first + kFan, counts_[below]);
      for (std::size_t child = first; child < last; ++child) {
        const double d = squared_distance(boxes_[begins_[below] + child], at);
        if (d >= *squared) continue;
        stack[size++] = {below, static_cast<std::uint32_t>(child), d};
        for (std::size_t i = size - 1; i > before && stack[i - 1].squared < d; --i) {
          std::swap(stack[i], stack[i - 1]);
        }
      }
    }
  }

 private:
  static constexpr std::size_t kFan = 8;
  static constexpr std::size_t kDepth = 13;  // 8^11 > 2^32, and the level above
  static constexpr std::size_t kBlock = 4096;

  // Relative to the origin, rounded outwards.
  struct Box {
    std::array<float, 3> low, high;
  };
  struct Node {
    std::uint32_t level, index;
    double squared;
  };

  static bool holds(const Box& box, const Vec3<double>& p, double margin) {
    return p.x >= box.low[0] - margin && p.x <= box.high[0] + margin &&
           p.y >= box.low[1] - margin && p.y <= box.high[1] + margin &&
           p.z >= box.low[2] - margin && p.z <= box.high[2] + margin;
  }
  static double beyond(double x, double low, double high) {
    return x < low ? low - x : x > high ? x - high : 0;
  }
  static double squared_distance(const Box& box, const Vec3<double>& p) {
    const double x = beyond(p.x, box.low[0], box.high[0]);
    const double y = beyond(p.y, box.low[1], box.high[1]);
    const double z = beyond(p.z, box.low[2], box.high[2]);
    return x * x + y * y + z * z;
  }
  // The node whose children are all of the uppermost level.
  void push_level_above(std::array<Node, kDepth * kFan>* stack, std::size_t* size) const {
    (*stack)[(*size)++] = {static_cast<std::uint32_t>(levels_), 0, 0};
  }

  Box narrow(const PointBox& box) const;
  void begin_levels(std::size_t items);
  // Of a level, from the one below.
  void join_boxes(std::size_t level, std::size_t begin, std::size_t end);

  Vec3<double> origin_{};
  Vector<Box> boxes_;  // of the items, then of eight of them each, and so on
  std::size_t levels_ = 0;
  std::array<std::size_t, kDepth> begins_{};
  std::array<std::size_t, kDepth> counts_{};  // the last level has at most kFan
};

}  // namespace tetfusion
