// Which points have the very same coordinates.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "base/vector.h"
#include "compare/point.h"

namespace tetfusion {

// A hash table of points, which must outlive it: 12 to 20 bytes a point. Const functions may be
// called from several threads.
class PointTable {
 public:
  explicit PointTable(std::span<const Point> points)
      : points_(points), slots_(std::bit_ceil(2 * points.size() + 1), kNone), next_(points.size()) {
    for (auto i = static_cast<std::uint32_t>(points.size()); i-- > 0;) {
      const std::size_t slot = find(points[i]);
      next_[i] = slots_[slot];
      slots_[slot] = i;
    }
  }

  // Calls f(number) for all points with the coordinates of p, ascending.
  template <class F>
  void for_each_at(const Point& p, F f) const {
    for (std::uint32_t i = slots_[find(p)]; i != kNone; i = next_[i]) f(i);
  }
  // The first of them, of a point that is one of all.
  std::uint32_t first_at(const Point& p) const { return slots_[find(p)]; }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  static std::uint64_t mix(std::uint64_t x) {
    x ^= x >> 32;
    x *= 0xD6E8FEB86659FD93u;
    return x ^ x >> 32;
  }
  std::size_t slot_of(const Point& p) const {
    // -0 and 0 are the same coordinate.
    std::uint64_t hash = mix(std::bit_cast<std::uint64_t>(p.x + 0.0));
    hash = mix(hash + std::bit_cast<std::uint64_t>(p.y + 0.0));
    hash = mix(hash + std::bit_cast<std::uint64_t>(p.z + 0.0));
    return hash & (slots_.size() - 1);
  }
  // The slot of the first point there, or the free one where it would be.
  std::size_t find(const Point& p) const {
    std::size_t slot = slot_of(p);
    while (slots_[slot] != kNone && !(points_[slots_[slot]] == p)) slot = after(slot);
    return slot;
  }
  std::size_t after(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }

  std::span<const Point> points_;
  Vector<std::uint32_t> slots_;  // a power of two: the first point of each place
  Vector<std::uint32_t> next_;   // in the same place
};

}  // namespace tetfusion
