#include "mesh/tet_overlap.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "mesh/predicates.h"

namespace tetfusion {

namespace {

// The points x with normal . (x - at) >= 0.
struct HalfSpace {
  Vec3<double> at, normal;
  double height(const Vec3<double>& x) const {
    return normal.x * (x.x - at.x) + normal.y * (x.y - at.y) + normal.z * (x.z - at.z);
  }
};

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
  struct Corner {
    double height;
    Vec3<double> at;
  };
  std::array<Corner, 4> c{};
  for (std::size_t i = 0; i < 4; ++i) c[i] = {by[0].height(tet[i]), tet[i]};
  // Those inside come first.
  const auto outside =
      std::stable_partition(c.begin(), c.end(), [](const Corner& x) { return x.height >= 0; });
  const auto cut = [&](std::size_t i, std::size_t j) {
    return between(c[i].at, c[j].at, c[i].height / (c[i].height - c[j].height));
  };
  const auto rest = by.subspan(1);
  switch (outside - c.begin()) {
    case 0:
      return 0;
    case 1:
      return clipped({c[0].at, cut(0, 1), cut(0, 2), cut(0, 3)}, rest);
    case 2:
      return clipped({c[0].at, cut(0, 2), cut(0, 3)}, {c[1].at, cut(1, 2), cut(1, 3)}, rest);
    case 3:
      return clipped({c[0].at, c[1].at, c[2].at}, {cut(0, 3), cut(1, 3), cut(2, 3)}, rest);
    default:
      return clipped(tet, rest);
  }
}

bool apart(const TetCorners& a, const TetCorners& b, double Vec3<double>::*axis) {
  const auto less = [axis](const Vec3<double>& x, const Vec3<double>& y) {
    return x.*axis < y.*axis;
  };
  const auto [a_lo, a_hi] = std::minmax_element(a.begin(), a.end(), less);
  const auto [b_lo, b_hi] = std::minmax_element(b.begin(), b.end(), less);
  return (*a_hi).*axis <= (*b_lo).*axis || (*b_hi).*axis <= (*a_lo).*axis;
}

}  // namespace

// About a corner of a, so that where it is cut is not rounded to units of places far away.
double overlap(const TetCorners& first, const TetCorners& second) {
  TetCorners a = first, b = second;
  for (TetCorners* tet : {&a, &b}) {
    for (Vec3<double>& p : *tet) p = {p.x - first[0].x, p.y - first[0].y, p.z - first[0].z};
  }
  if (apart(a, b, &Vec3<double>::x) || apart(a, b, &Vec3<double>::y) ||
      apart(a, b, &Vec3<double>::z)) {
    return 0;
  }
  const std::array<HalfSpace, 4> sides{
      through(b[1], b[2], b[3], b[0]), through(b[0], b[2], b[3], b[1]),
      through(b[0], b[1], b[3], b[2]), through(b[0], b[1], b[2], b[3])};
  for (const HalfSpace& side : sides) {
    if (std::all_of(a.begin(), a.end(), [&](const auto& x) { return side.height(x) <= 0; })) {
      return 0;
    }
  }
  return clipped(a, sides);
}

}  // namespace tetfusion
