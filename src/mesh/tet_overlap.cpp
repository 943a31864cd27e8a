#include "mesh/tet_overlap.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "mesh/predicates.h"

namespace tetfusion {

namespace {

HalfSpace through(const Vec3<double>& a, const Vec3<double>& b, const Vec3<double>& c,
                  const Vec3<double>& inside) {
  const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
  const double vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  HalfSpace h{a, {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx}};
  if (h.height(inside) < 0) h.normal = {-h.normal.x, -h.normal.y, -h.normal.z};
  return h;
}

Vec3<double> between(const Vec3<double>& a, const Vec3<double>& b, double t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
}

double clipped(const TetCorners& tet, std::span<const HalfSpace> by);

// A prism between the triangles a and b.
double clipped(const std::array<Vec3<double>, 3>& a, const std::array<Vec3<double>, 3>& b,
               std::span<const HalfSpace> by) {
  return clipped({a[0], a[1], a[2], b[2]}, by) + clipped({a[0], a[1], b[2], b[1]}, by) +
         clipped({a[0], b[1], b[2], b[0]}, by);
}

// What is left of a tetrahedron in all of the half-spaces.
double clipped(const TetCorners& tet, std::span<const HalfSpace> by) {
  if (by.empty()) return std::abs(determinant(tet[0], tet[1], tet[2], tet[3]).value);
  std::array<double, 4> height{};
  std::array<std::size_t, 4> order{};  // those inside first
  std::size_t inside = 0, next = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    height[i] = by[0].height(tet[i]);
    if (height[i] >= 0) order[inside++] = i;
  }
  next = inside;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(height[i] >= 0)) order[next++] = i;
  }
  const auto corner = [&](std::size_t i) { return tet[order[i]]; };
  const auto cut = [&](std::size_t i, std::size_t j) {
    const double from = height[order[i]], to = height[order[j]];
    return between(corner(i), corner(j), from / (from - to));
  };
  const auto rest = by.subspan(1);
  switch (inside) {
    case 0:
      return 0;
    case 1:
      return clipped({corner(0), cut(0, 1), cut(0, 2), cut(0, 3)}, rest);
    case 2:
      return clipped({corner(0), cut(0, 2), cut(0, 3)}, {corner(1), cut(1, 2), cut(1, 3)}, rest);
    case 3:
      return clipped({corner(0), corner(1), corner(2)}, {cut(0, 3), cut(1, 3), cut(2, 3)}, rest);
    default:
      return clipped(tet, rest);
  }
}

Vec3<double> about(const Vec3<double>& origin, const Vec3<double>& p) {
  return {p.x - origin.x, p.y - origin.y, p.z - origin.z};
}

}  // namespace

OverlapTet::OverlapTet(const TetCorners& corners, const Vec3<double>& origin)
    : corners_{about(origin, corners[0]), about(origin, corners[1]), about(origin, corners[2]),
               about(origin, corners[3])},
      least_(corners_[0]),
      most_(corners_[0]),
      sides_{through(corners_[1], corners_[2], corners_[3], corners_[0]),
             through(corners_[0], corners_[2], corners_[3], corners_[1]),
             through(corners_[0], corners_[1], corners_[3], corners_[2]),
             through(corners_[0], corners_[1], corners_[2], corners_[3])} {
  for (const Vec3<double>& p : corners_) {
    least_ = {std::min(least_.x, p.x), std::min(least_.y, p.y), std::min(least_.z, p.z)};
    most_ = {std::max(most_.x, p.x), std::max(most_.y, p.y), std::max(most_.z, p.z)};
  }
  const auto& c = corners_;
  lanes_ = {{{DoubleLanes{c[0].x, c[1].x}, DoubleLanes{c[2].x, c[3].x}},
             {DoubleLanes{c[0].y, c[1].y}, DoubleLanes{c[2].y, c[3].y}},
             {DoubleLanes{c[0].z, c[1].z}, DoubleLanes{c[2].z, c[3].z}}}};
}

auto OverlapTet::cut(const OverlapTet& other) const -> Cut {
  Cut cut;
  for (const HalfSpace& side : sides_) {
    const auto [first, last] = side.heights(other.lanes_);
    const auto behind = (first < 0.0) | (last < 0.0), before = (first > 0.0) | (last > 0.0);
    if ((behind[0] | behind[1]) != 0) cut.sides[cut.count++] = side;
    cut.all = (before[0] | before[1]) == 0;
    if (cut.all) break;
  }
  return cut;
}

// Whichever is cut less is cut.
double OverlapTet::with(const OverlapTet& other) const {
  if (most_.x <= other.least_.x || other.most_.x <= least_.x || most_.y <= other.least_.y ||
      other.most_.y <= least_.y || most_.z <= other.least_.z || other.most_.z <= least_.z) {
    return 0;
  }
  const Cut of_other = cut(other);
  if (of_other.all) return 0;
  const Cut of_this = other.cut(*this);
  if (of_this.all) return 0;
  return of_this.count <= of_other.count
             ? clipped(corners_, std::span(of_this.sides).first(of_this.count))
             : clipped(other.corners_, std::span(of_other.sides).first(of_other.count));
}

}  // namespace tetfusion
