// Places about a vertex, in the unit of lengths: small numbers, whatever the mesh's are.
#pragma once

#include "kernel/point3.h"
#include "kernel/sheets/facing_grid.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

template <class Real>
struct LocalFrame {
  Vec3<Real> origin{};
  double unit = 1;

  Point3 local(const Vec3<Real>& p) const {
    return {(double{p.x} - origin.x) * unit, (double{p.y} - origin.y) * unit,
            (double{p.z} - origin.z) * unit};
  }
  // And back.
  Point3 in_mesh(const Point3& p) const {
    return {p[0] / unit + origin.x, p[1] / unit + origin.y, p[2] / unit + origin.z};
  }
  FacingBox in_mesh(const FacingBox& box) const { return {in_mesh(box.lo), in_mesh(box.hi)}; }
};

}  // namespace tetfusion
