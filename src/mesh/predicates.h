// The sign of a tetrahedron's volume, with a bound on the rounding error: a sign that cannot be
// trusted is reported as 0.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/geometry.h"

namespace tetfusion {

// Determinant of (b-a, c-a, d-a) and a bound on its error. The determinant is six times the signed
// volume of the tetrahedron (a, b, c, d), positive for VTK's winding.
struct Determinant {
  double value;
  double error;
  // +1 or -1 when the sign is certain, else 0. Overflow and NaN give 0.
  int sign() const {
    constexpr double kLargest = std::numeric_limits<double>::max();
    if (value > error) return value <= kLargest ? 1 : 0;
    if (value < -error) return value >= -kLargest ? -1 : 0;
    return 0;
  }
};

namespace detail {

// Shewchuk (1997, "Adaptive precision floating-point arithmetic", section 4.3) bounds the error of
// this evaluation, differences included, by (7 + 56 eps) eps times the sum of the absolute
// products, with eps = 2^-53. That sum is at most six times the product of the largest components.
// Underflow adds at most 2^-1075 for each product of two, which is then multiplied by a component
// of w (six of them, and the bound's own), and for each product of that: kTiny and the smallest
// normal number are more than enough.
inline constexpr double kDeterminantBound = 6 * 7.1 * 0x1p-53;
inline constexpr double kTiny = 0x1p-1070;

}  // namespace detail

// The bound for w . (u x v), by the largest components of each.
inline double determinant_error(double u, double v, double w) {
  return (detail::kDeterminantBound * u * v + detail::kTiny) * w +
         std::numeric_limits<double>::min();
}

template <class Real>
inline Determinant determinant(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                               const Vec3<Real>& d) {
  const double ax = a.x, ay = a.y, az = a.z;
  const double ux = b.x - ax, uy = b.y - ay, uz = b.z - az;
  const double vx = c.x - ax, vy = c.y - ay, vz = c.z - az;
  const double wx = d.x - ax, wy = d.y - ay, wz = d.z - az;
  const double value =
      wx * (uy * vz - uz * vy) + wy * (uz * vx - ux * vz) + wz * (ux * vy - uy * vx);
  const double mu = std::max(std::max(std::abs(ux), std::abs(uy)), std::abs(uz));
  const double mv = std::max(std::max(std::abs(vx), std::abs(vy)), std::abs(vz));
  const double mw = std::max(std::max(std::abs(wx), std::abs(wy)), std::abs(wz));
  return {value, determinant_error(mu, mv, mw)};
}

template <class Real>
inline Determinant determinant(const Vector<Vec3<Real>>& p, const Tet& t) {
  return determinant(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
}

}  // namespace tetfusion
