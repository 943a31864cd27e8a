// Points in double precision, whatever the type of the file.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/point_box.h"
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

}  // namespace tetfusion
