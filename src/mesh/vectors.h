// Vectors in double precision.
#pragma once

#include "mesh/geometry.h"

namespace tetfusion {

template <class Real>
Vec3<double> in_double(const Vec3<Real>& p) {
  return {p.x, p.y, p.z};
}

template <class Real>
Vec3<double> difference(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z};
}

inline double dot(const Vec3<double>& a, const Vec3<double>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Vec3<double> cross(const Vec3<double>& a, const Vec3<double>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace tetfusion
