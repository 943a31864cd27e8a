// The mean ratio of a tetrahedron, cubed, as the kernel goes by it.
#pragma once

#include "mesh/geometry.h"

namespace tetfusion {

// 432 times the squared determinant over this is the cubed mean ratio: the cube of the sum of the
// squared edges. One corner is the origin.
struct CellShape {
  double det;
  double edges;

  double cubed_mean_ratio() const { return 432 * det * det / (edges * edges * edges); }
};

// Of coordinates times the unit, in which their sixth powers are numbers.
template <class Real>
inline CellShape shape_of(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                          const Vec3<Real>& d, double unit) {
  const double ax = a.x, ay = a.y, az = a.z;
  const double ux = (b.x - ax) * unit, uy = (b.y - ay) * unit, uz = (b.z - az) * unit;
  const double vx = (c.x - ax) * unit, vy = (c.y - ay) * unit, vz = (c.z - az) * unit;
  const double wx = (d.x - ax) * unit, wy = (d.y - ay) * unit, wz = (d.z - az) * unit;
  const double det = wx * (uy * vz - uz * vy) + wy * (uz * vx - ux * vz) + wz * (ux * vy - uy * vx);
  const double x = ux + vx + wx, y = uy + vy + wy, z = uz + vz + wz;
  const double squares =
      (ux * ux + uy * uy + uz * uz) + (vx * vx + vy * vy + vz * vz) + (wx * wx + wy * wy + wz * wz);
  return {det, 4 * squares - (x * x + y * y + z * z)};
}

}  // namespace tetfusion
