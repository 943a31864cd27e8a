// The quadrics of a mesh's vertices (quadric.h), and what else a vertex knows of its fusions, as
// rows of WorkMesh::quadrics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/criteria.h"
#include "kernel/quadrics/quadric.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Numbers in a row: the quadric; where sheets (sheets.h) may move, that of the sheet, which is one
// without fields; and what the vertex's cheapest fusion costs, negative where that has failed in
// the last round, or 0 where nobody knows.
constexpr std::uint32_t quadric_row(std::uint32_t steering_width, bool sheets_move = false) {
  return static_cast<std::uint32_t>(quadric_size(steering_width) +
                                    (sheets_move ? quadric_size(0) : 0) + 1);
}

// Gives each vertex no deviation, where the mesh has deviations, and the quadric of its tetrahedra
// in the mesh, with lengths in this unit (they are multiplied by it; a power of two, so that the
// scale of a mesh does not matter) and fields as shares of their ranges. A tetrahedron with a value
// that is no number, or without certain volume, is left out.
template <class Real>
void begin_quadrics(std::span<const SteeringField> fields, double unit, WorkMesh<Real>* mesh);

// The last number of the vertex's row.
template <class Real>
float& known_cost(WorkMesh<Real>* mesh, VertexId v) {
  return mesh->quadrics[(std::size_t{v} + 1) * mesh->quadric_width - 1];
}
template <class Real>
float known_cost(const WorkMesh<Real>& mesh, VertexId v) {
  return mesh.quadrics[(std::size_t{v} + 1) * mesh.quadric_width - 1];
}

}  // namespace tetfusion
