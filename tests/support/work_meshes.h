// Small meshes as the kernel takes them.
#pragma once

#include "mesh/geometry.h"
#include "mesh/work_mesh.h"

namespace tetfusion::testing {

// A mesh whose ids are the geometry's, marked as `inspect` finds it; without steering values.
WorkMesh<double> to_work_mesh(Geometry geometry);
WorkMesh<float> to_float_work_mesh(Geometry geometry);

// One steering value a vertex: f(x, y, z).
template <class Real, class F>
void steer_by(F&& f, WorkMesh<Real>* mesh) {
  mesh->steering_width = 1;
  mesh->steering.clear();
  for (const Vec3<Real>& p : mesh->positions) mesh->steering.push_back(f(p.x, p.y, p.z));
}

}  // namespace tetfusion::testing
