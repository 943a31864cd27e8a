// The mesh as passes see it: flat arrays, and ids that change from pass to pass. A chunk is one of
// these too.
#pragma once

#include <cstdint>
#include <vector>

#include "base/copy_few.h"
#include "base/vector.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"
#include "mesh/removed_points.h"

namespace tetfusion {

// What a pass may not do with a vertex, as bits.
enum VertexMark : std::uint8_t {
  kOnBoundary = 1 << 0,  // lies on the boundary surface
  kLocked = 1 << 1,      // must stay for another reason: a broken cell, a carried cell, a region's
                         // interface, a value that is no number
  kNearBoundary =
      1 << 2,             // one of its tetrahedra is a boundary tetrahedron; see mark_near_boundary
  kOnInterface = 1 << 3,  // in a chunk: other chunks have tetrahedra of it; it stays for this round
  kUndecided = 1 << 4,    // while a chunk is gathered from pieces, none of which has it
  kLast = 1 << 5,         // in a chunk, of a vertex on the interface: no higher chunk has it
  kCarried = 1 << 6,      // while it is imported: a cell of lower dimension uses it
  kMoved = 1 << 7,        // fused to a new place: no point of the original any more
};

// The rows of an array that is carried along: tuples of one type, in native byte order.
struct Column {
  ValueType type = ValueType::kFloat32;
  std::uint32_t components = 1;
  Vector<std::byte> rows;

  std::size_t stride() const { return components * size_of(type); }  // bytes a tuple
  void resize(std::size_t tuples) { rows.resize(tuples * stride()); }
  void move_row(std::size_t from, std::size_t to) {
    const std::size_t n = stride();
    copy_few(rows.data() + from * n, n, rows.data() + to * n);
  }
};

template <class Real>
struct WorkMesh {
  Vector<Vec3<Real>> positions;
  Vector<std::uint8_t> marks;  // VertexMark bits, one a vertex
  Vector<double> steering;     // steering_width values a vertex
  std::uint32_t steering_width = 0;
  // quadric_width numbers a vertex (kernel/quadrics/quadric.h); 0: nobody wants them. A chunk has a
  // part of the quadric of a vertex on the interface, and all parts add up.
  Vector<float> quadrics;
  std::uint32_t quadric_width = 0;
  // How far sheets (kernel/sheets/sheets.h) may have moved since the beginning, in the unit of
  // quadrics: a triangle of one by no more than the largest of its corners'. Where they may not
  // move at all there are none.
  bool has_deviations = false;
  Vector<float> deviations;
  // Each vertex's id in the beginning: the same in every chunk that has the vertex. A fused one
  // keeps one of those that became it.
  Vector<VertexId> point_ids;
  Vector<std::uint32_t> incidence;  // tetrahedra here that use the vertex
  Vector<std::uint16_t> changed;    // the last pass that changed the vertex's ball; 0: none yet
  std::vector<Column> point_columns;

  Vector<Tet> tets;  // all of positive volume, but for those at locked vertices
  // What the method remembers of each: of tetfuse the last pass that refused it as a flip, of fuse,
  // which wants quadrics, its grade (kernel/shapes/shape_grades.h). 0: nothing yet.
  Vector<std::uint16_t> remembered;
  RemovedPoints<Real> removed;
  std::vector<Column> cell_columns;

  std::size_t vertex_count() const { return positions.size(); }
  void resize_vertices(std::size_t vertices);
  void resize_tets(std::size_t tets);
};

// Sets kNearBoundary where it belongs. Passes do not change whether a vertex is near the boundary
// as long as they touch no vertex that is.
template <class Real>
void mark_near_boundary(WorkMesh<Real>* mesh);

// In a chunk: a higher one has the vertex, too, and counts it.
inline bool is_counted_elsewhere(std::uint8_t marks) {
  return (marks & (kOnInterface | kLast)) == kOnInterface;
}

// A tetrahedron that is gone is marked in place.
inline bool is_deleted(const Tet& tet) { return tet[0] == kNoVertex; }
inline void mark_deleted(Tet* tet) { (*tet)[0] = kNoVertex; }

// Drops them, and the vertices of incidence 0. All others keep their order; ids are stale.
template <class Real>
void drop_deleted(WorkMesh<Real>* mesh);

}  // namespace tetfusion
