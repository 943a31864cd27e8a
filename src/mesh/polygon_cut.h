// Polygons as triangles: the faces of polyhedra, and cells that lie on them.
//
// Whoever has the polygon cuts it alike, wherever its list of vertices begins and whichever way it
// goes round: the tetrahedra on its two sides conform. A quadrilateral is cut from its smallest
// vertex, as the faces of other cells are (split_cells.h), unless three vertices in line make one
// of its triangles flat and the other diagonal's are not. Others are cut so that the worst triangle
// is as good as it can be: vertices that hang on a straight side cost nothing, and dents are no
// trouble.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mesh/geometry.h"

namespace tetfusion {

// Keeps its memory from polygon to polygon. Not thread-safe.
class PolygonCut {
 public:
  // The triangles, wound as the polygon is, until the next call. A vertex that follows itself
  // counts once; a polygon of fewer than three has none. One of more than 64, or that comes back to
  // a vertex, is cut from its smallest vertex, whatever comes of it. REQUIRES: as many positions as
  // ids.
  std::span<const std::array<VertexId, 3>> cut(std::span<const VertexId> ids,
                                               std::span<const Vec3<double>> positions);

 private:
  struct Corner {
    VertexId id;
    Vec3<double> position;
  };
  bool take(std::span<const VertexId> ids, std::span<const Vec3<double>> positions);
  double quality(std::size_t i, std::size_t j, std::size_t k) const;
  void cut_from(std::size_t first);
  void cut_quadrilateral();
  void cut_best();
  void add(std::size_t i, std::size_t j, std::size_t k);

  std::vector<Corner> corners_;  // from the smallest on, and on to the smaller of its neighbours
  bool is_turned_ = false;       // against the order in which they came
  Vec3<double> normal_{};        // twice the area
  std::vector<double> worst_;    // of what lies between corners i and j, at i * n + j
  std::vector<std::size_t> third_;
  std::vector<std::array<std::size_t, 2>> open_;
  std::vector<std::array<VertexId, 3>> triangles_;
};

}  // namespace tetfusion
