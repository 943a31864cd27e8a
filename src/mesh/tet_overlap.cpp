#include "mesh/tet_overlap.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "mesh/predicates.h"
#include "mesh/vectors.h"

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

TetCorners about(const Vec3<double>& origin, const TetCorners& corners) {
  TetCorners out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = difference(corners[i], origin);
  return out;
}

}  // namespace

auto OverlapTet::lanes_of(const TetCorners& c) -> Lanes4 {
  return {{{DoubleLanes{c[0].x, c[1].x}, DoubleLanes{c[2].x, c[3].x}},
           {DoubleLanes{c[0].y, c[1].y}, DoubleLanes{c[2].y, c[3].y}},
           {DoubleLanes{c[0].z, c[1].z}, DoubleLanes{c[2].z, c[3].z}}}};
}

auto OverlapTet::sides_of(const TetCorners& c) -> Sides {
  return {through(c[1], c[2], c[3], c[0]), through(c[0], c[2], c[3], c[1]),
          through(c[0], c[1], c[3], c[2]), through(c[0], c[1], c[2], c[3])};
}

OverlapTet::OverlapTet(const TetCorners& corners)
    : origin_(corners[0]),
      least_(corners[0]),
      most_(corners[0]),
      corners_(about(origin_, corners)),
      lanes_(lanes_of(corners_)),
      sides_(sides_of(corners_)) {
  for (const Vec3<double>& p : corners) {
    least_ = {std::min(least_.x, p.x), std::min(least_.y, p.y), std::min(least_.z, p.z)};
    most_ = {std::max(most_.x, p.x), std::max(most_.y, p.y), std::max(most_.z, p.z)};
  }
}

bool OverlapTet::is_near(const TetCorners& other) const {
  const auto meets = [&](double Vec3<double>::*axis) {
    const auto [least, most] =
        std::minmax({other[0].*axis, other[1].*axis, other[2].*axis, other[3].*axis});
    return least < most_.*axis && least_.*axis < most;
  };
  return meets(&Vec3<double>::x) && meets(&Vec3<double>::y) && meets(&Vec3<double>::z);
}

auto OverlapTet::cut(const Lanes4& points, const Sides& by) -> Cut {
  Cut cut;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [first, last] = by[i].heights(points);
    const auto behind = (first < 0.0) | (last < 0.0), before = (first > 0.0) | (last > 0.0);
    if ((behind[0] | behind[1]) != 0) {
      cut.sides[cut.count++] = by[i];
      cut.which |= 1u << i;
    }
    cut.all = (before[0] | before[1]) == 0;
    if (cut.all) break;
  }
  return cut;
}

// Whichever is cut less is cut.
Overlap OverlapTet::with(const TetCorners& other) const {
  if (!is_near(other)) return {};
  const TetCorners corners = about(origin_, other);
  const Cut of_other = cut(lanes_of(corners), sides_);
  if (of_other.all) return {};
  const Cut of_this = cut(lanes_, sides_of(corners));
  if (of_this.all) return {};
  const double volume = of_this.count <= of_other.count
                            ? clipped(corners_, std::span(of_this.sides).first(of_this.count))
                            : clipped(corners, std::span(of_other.sides).first(of_other.count));
  return volume > 0 ? Overlap{volume, of_this.which} : Overlap{};
}

}  // namespace tetfusion
