// Where a point lies in the simplified mesh.
#pragma once

#include <array>
#include <cstdint>

#include "compare/point.h"
#include "compare/point_table.h"
#include "compare/simplified_mesh.h"
#include "compare/triangles.h"
#include "mesh/box_tree.h"

namespace tetfusion {

// The value at the place is the sum of the weights times the values at the corners.
struct Place {
  TetId tet;
  std::array<double, 4> weights;  // 0 to 1; the sum is 1
  bool outside;     // farther from the mesh than rounding explains: the place is the nearest point
                    // of the boundary
  double distance;  // then: how far that is; else 0
};

// Where the last search ended. A search begins there.
struct LocatorHint {
  TetId tet = kNoTet;
  std::uint32_t triangle = 0;
};

// A point lies in a tetrahedron if it is not certainly on the far side of one of its faces (so
// there are no gaps between tetrahedra), else in the tetrahedron or on the boundary triangle from
// which it is no farther than 4 eps times the sum of the point's largest coordinate and the longest
// side of the cell's box; eps is that of the files' coordinates. Where tetrahedra overlap, one of
// them is found. Tetrahedra without volume are never found, but through the boundary.
//
// The mesh must outlive this. Const functions may be called from several threads, each with a hint
// of its own; results depend on the hint only where there are several.
class Locator {
 public:
  Locator(const SimplifiedMesh* mesh, ValueType coarsest_point_type);

  // In a part of the mesh, or anywhere.
  Place locate(const Point& p, LocatorHint* hint, std::uint32_t part = kAnyPart) const;

  // The distance that rounding explains at most, in a box.
  double rounding_in(const PointBox& box) const;

  // Calls f(vertex) for all points of the part with the very coordinates of p.
  template <class F>
  void for_each_vertex_at(const Point& p, std::uint32_t part, F f) const {
    vertices_.for_each_at(p, [&](VertexId v) {
      if (part == kAnyPart || mesh_.part_of_point(v) == part) f(v);
    });
  }

 private:
  bool is_in(TetId t, std::uint32_t part) const {
    return part == kAnyPart || mesh_.part_of(t) == part;
  }
  bool walk(const Point& p, TetId* tet, Place* place) const;
  bool holds(TetId t, const Point& p, Place* place) const;
  bool find_close(const Point& p, std::uint32_t part, Place* place) const;
  Place find_on_boundary(const Point& p, std::uint32_t part, LocatorHint* hint) const;
  double tolerance(const Point& p, double extent) const;

  const SimplifiedMesh& mesh_;
  const double rounding_;
  double largest_extent_ = 0;  // of the mesh's box
  BoxTree tree_;
  TriangleFinder boundary_;
  PointTable vertices_;
};

}  // namespace tetfusion
