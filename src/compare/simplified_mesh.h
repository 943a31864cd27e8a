// The simplified mesh in memory, in an order that keeps neighbours together.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/vector.h"
#include "compare/fields.h"
#include "compare/parts.h"
#include "compare/point.h"
#include "compare/triangles.h"
#include "io/source/mesh_source.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct SimplifiedMesh {
  Vector<Point> points;       // those that a tetrahedron uses
  Vector<Tet> tets;           // wound alike
  Vector<std::uint8_t> flat;  // one a tetrahedron: 1 if its volume cannot be told from 0
  // Behind the face opposite to each corner; kNoTet at the boundary, and where more than two
  // tetrahedra share the face.
  Vector<std::array<TetId, 4>> neighbours;
  TriangleSet boundary;                  // ordered
  Vector<std::uint32_t> boundary_sides;  // of each triangle: 4 * tetrahedron + opposite corner
  // What each point is part of, if there are several parts, and what these are recognised by.
  Vector<std::uint32_t> point_parts;
  std::vector<PartFigures> parts;
  Vector<std::uint32_t> point_ids, tet_ids;  // which points and tetrahedra of read_geometry()
  Vector<double> point_rows;                 // rows of the point fields, one a point
  Vector<double> cell_rows;                  // rows of the cell fields, one a tetrahedron
  PointBox box;
  double volume = 0;
  double volume_error = 0;  // what rounding may have done to it at most

  std::uint32_t part_of_point(VertexId v) const {
    return point_parts.empty() ? kAnyPart : point_parts[v];
  }
  std::uint32_t part_of(TetId t) const { return part_of_point(tets[t][0]); }
  Corners corners(TetId t) const {
    const Tet& tet = tets[t];
    return {points[tet[0]], points[tet[1]], points[tet[2]], points[tet[3]]};
  }
};

// Reads all of it, and the arrays of the fields. Throws what reading throws, and Error(kBadInput)
// if the mesh has no boundary.
SimplifiedMesh load_simplified(MeshSource* source, const FieldSet& point_fields,
                               const FieldSet& cell_fields);

}  // namespace tetfusion
