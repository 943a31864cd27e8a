// Points and boxes, in double precision whatever the type of the file.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "mesh/geometry.h"
#include "mesh/vectors.h"

namespace tetfusion {

using Point = Vec3<double>;
using Corners = std::array<Point, 4>;  // of a tetrahedron

inline Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator*(double s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
inline bool operator==(const Point& a, const Point& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
inline double length(const Point& a) { return std::sqrt(dot(a, a)); }
inline double largest_part(const Point& a) {
  return std::max(std::max(std::abs(a.x), std::abs(a.y)), std::abs(a.z));
}

struct PointBox {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
            std::numeric_limits<double>::infinity()};
  Point high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};

  bool empty() const { return low.x > high.x; }
  void add(const Point& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const PointBox& box) {
    add(box.low);
    add(box.high);
  }
  Point extent() const { return empty() ? Point{0, 0, 0} : high - low; }
  Point centre() const { return empty() ? Point{0, 0, 0} : low + 0.5 * (high - low); }
};

PointBox box_of(std::span<const Point> points);

// The numbers of the keys, of so many bits, in ascending order of these; equal keys keep their
// order.
Vector<std::uint32_t> sorted_by_key(const Vector<std::uint32_t>& keys, int bits);

}  // namespace tetfusion
