// The mesh as passes see it: flat arrays, ids that change from pass to pass, and for each vertex
// and tetrahedron the id it had in the beginning. A chunk is one of these too.
#pragma once

#include <cstdint>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// What a pass may not do with a vertex, as bits.
enum VertexMark : std::uint8_t {
  kOnBoundary = 1 << 0,  // lies on the boundary surface
  kLocked = 1 << 1,  // must stay for another reason: a broken cell, a carried cell, a value that is
                     // no number
  kNearBoundary = 1 << 2,  // one of its tetrahedra is a boundary tetrahedron
  kOnInterface = 1 << 3,  // in a chunk: other chunks have tetrahedra of it; it stays for this round
};

template <class Real>
struct WorkMesh {
  Vector<Vec3<Real>> positions;
  Vector<std::uint8_t> marks;  // VertexMark bits, one a vertex
  Vector<double> steering;     // steering_width values a vertex
  std::uint32_t steering_width = 0;
  Vector<VertexId>
      point_ids;  // each vertex's id in the beginning; a fused one keeps one of its four
  Vector<std::uint32_t> incidence;  // tetrahedra that use the vertex
  Vector<std::uint16_t> changed;    // the last pass that changed the vertex's ball; 0: none yet
  Vector<Tet> tets;                 // all of positive volume, but for those at locked vertices
  Vector<TetId> tet_ids;            // each tetrahedron's id in the beginning
  Vector<std::uint16_t>
      flipped;  // the last pass that refused the tetrahedron as a flip; 0: none yet

  std::size_t vertex_count() const { return positions.size(); }
};

// Counts the incidence of every vertex.
template <class Real>
void count_incidence(WorkMesh<Real>* mesh);

// Drops the vertices of incidence 0, but for locked ones (a carried cell may be all they have) and
// those on an interface (whose incidence counts changes). The others keep their order; returns
// their new ids, which the tetrahedra are yet to be given.
template <class Real>
Vector<VertexId> drop_unused_vertices(WorkMesh<Real>* mesh);

}  // namespace tetfusion
