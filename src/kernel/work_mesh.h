// The mesh as a pass sees it: flat arrays, ids that change from pass to pass, and for each vertex and
// tetrahedron the id it had in the beginning.
#pragma once

#include <cstdint>
#include <optional>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// What a pass may not do with a vertex, as bits.
enum VertexMark : std::uint8_t {
  kOnBoundary = 1 << 0,    // lies on the boundary surface
  kLocked = 1 << 1,        // must stay for another reason: a broken cell, a carried cell, a value that is no number
  kNearBoundary = 1 << 2,  // one of its tetrahedra is a boundary tetrahedron
};

// A field that steers: its values are components [first, first + count) of a vertex's steering tuple.
struct SteeringField {
  std::uint32_t first = 0;
  std::uint32_t count = 1;
  double range = 0;  // of the whole original mesh; a vector's is the diagonal of its component box. > 0
  std::optional<double> tolerance;  // share of the range, in place of the pass's scalar tolerance
};

template <class Real>
struct WorkMesh {
  Vector<Vec3<Real>> positions;
  Vector<std::uint8_t> marks;  // VertexMark bits, one a vertex
  Vector<double> steering;     // steering_width values a vertex
  std::uint32_t steering_width = 0;
  Vector<VertexId> point_ids;  // each vertex's id in the input geometry; a fused one keeps one of its four
  Vector<Tet> tets;            // all of positive volume, but for those at locked vertices
  Vector<TetId> tet_ids;       // each tetrahedron's id in the input geometry

  std::size_t vertex_count() const { return positions.size(); }
};

}  // namespace tetfusion
