// Puts points and tetrahedra in the order of a space-filling curve, so that a walk through the mesh
// is a walk through memory.
#pragma once

#include <span>

#include "mesh/geometry.h"

namespace tetfusion {

// new2old: the points along the Hilbert curve through their bounding box; ties keep their order.
// The same for any number of threads. Coordinates must be finite.
Vector<VertexId> points_along_curve(const Points& points);

// new2old: the tetrahedra by their smallest vertex id; ties keep their order. With points along the
// curve the tetrahedra follow it too.
Vector<TetId> tets_by_first_vertex(std::span<const Tet> tets, std::size_t vertices);

// Puts a whole geometry in that order: points, then tetrahedra. Cells of lower dimension keep their
// places and name the points by their new ids; the *_source arrays are filled, so that they still
// lead to the input's rows.
void order_along_curve(Geometry* geometry);

}  // namespace tetfusion
