// Which tetrahedron has a point: found by walks, from one tetrahedron to the next.
#pragma once

#include <array>
#include <cstdint>

#include "kernel/fit/start_grid.h"
#include "mesh/box_tree.h"
#include "mesh/tet_neighbours.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Of a tetrahedron's corners: volumes with the point in a corner's place, as shares of the
// tetrahedron's.
template <class Real>
std::array<double, 4> weights_in(const Vec3<double>& point,
                                 const std::array<Vec3<Real>, 4>& corners);

// Begin with a mesh, and find points; keeps its memory; one a thread.
template <class Real>
class TetWalk {
 public:
  // Where a point lies: the first corner's weight is what the others leave of 1.
  struct Place {
    std::array<double, 3> weights;
    TetId tet;
    bool outside = false;  // of all tetrahedra
  };

  // The mesh has tetrahedra, and they do not change as long as points are looked for; it outlives
  // that. Where positions change, find() begins where they were: it may have further to go.
  void begin(const WorkMesh<Real>& mesh);

  // Looks where the point before was, then near the point, then around it, as there may be a crack
  // on the way; best is the order in which points lie near each other. False: it is outside, or
  // hard to reach.
  bool find(const Vec3<double>& point);
  // By a walk from `start`, a point inside, so that no crack is crossed. What is not far outside
  // is placed where the walk ended, with weights below zero.
  bool find_from(const Vec3<double>& start, const Vec3<double>& point);

  // From that tetrahedron, where corners of the mesh have moved since a point was found there.
  bool find_again(TetId tet, const Vec3<double>& point) { return walk(tet, kWalkFromStart, point); }

  // Does a tetrahedron at the boundary have its centre well inside another one, of thousands that
  // are looked at? Where parts lie over each other nobody can say to which of them a point belongs:
  // then points are not found from here on that several tetrahedra have which touch nowhere.
  bool leave_out_overlaps();

  // Of the point that was found last.
  const Place& place() const { return last_; }

  // Of the mesh.
  const VertexTets& balls() const { return neighbours_.balls(); }

  // Bytes that takes for so many tetrahedra.
  static std::uint64_t memory(std::uint64_t tets);

 private:
  // Longer walks from the grid's start are lost: more is hardly ever needed.
  static constexpr int kWalkFromStart = 64;

  bool overlaps_itself();
  bool look_for(const Vec3<double>& point);
  bool is_in_another(const Vec3<double>& point) const;
  bool walk(TetId start, int longest, const Vec3<double>& point);
  bool place_nearby(const Vec3<double>& point);

  const WorkMesh<Real>* mesh_ = nullptr;
  TetNeighbours neighbours_;
  StartGrid<Real> starts_;
  BoxTree overlaps_;  // of the tetrahedra; empty: there are none
  Place last_{};
  TetId end_ = kNoTet;  // of the last walk, where it ended at a boundary
};

extern template std::array<double, 4> weights_in(const Vec3<double>&,
                                                 const std::array<Vec3<float>, 4>&);
extern template std::array<double, 4> weights_in(const Vec3<double>&,
                                                 const std::array<Vec3<double>, 4>&);
extern template class TetWalk<float>;
extern template class TetWalk<double>;

}  // namespace tetfusion
