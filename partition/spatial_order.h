// Puts a mesh in the order of a space-filling curve, so that a walk through the mesh is a walk
// through memory.
#pragma once

#include "mesh/work_mesh.h"
#include "partition/curve_cut.h"

namespace tetfusion {

// Brings `mesh`, of which nothing has been removed yet, to *out, which takes its columns' types
// from it and forgets what it had: vertices along the curve, then tetrahedra by their smallest
// vertex; ties keep their order. On one thread. Every tetrahedron must name vertices that there
// are.
template <class Real>
void order_along_curve(const ShiftedCurve& curve, const WorkMesh<Real>& mesh, WorkMesh<Real>* out);

}  // namespace tetfusion
