// Places of new vertices, nearer to where the original's fields bend.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "kernel/point3.h"
#include "kernel/position_wish.h"
#include "mesh/vertex_tets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Where a place lies: a tetrahedron, and the weights of its corners.
struct PlaceInTet {
  TetId tet = 0;
  std::array<double, 4> weights{};
};

// Fusing has put each vertex where its quadric wanted it; what errors are left at the original's
// points is known when all is done. Then each vertex goes a step towards less of them (Gauss and
// Newton), by itself, while its values follow (README.md).
//
// Begin with a mesh, add the errors of one component of the fields after another, and move; keeps
// its scratch memory; one a thread.
template <class Real>
class VertexMoves {
 public:
  // These may move. `balls` are the mesh's; all of that outlives the moves.
  void begin(WorkMesh<Real>* mesh, const VertexTets* balls, std::span<const VertexId> vertices);

  // A component whose squared errors count `scale` times: a point has this error, in a tetrahedron
  // in which the component has that gradient.
  void begin_component();
  void add(const PlaceInTet& point, double error, const Point3& gradient);
  void end_component(double scale);

  // Moves them, one after another, where that pays. No tetrahedron becomes worse than the floor, a
  // mean ratio, unless it was, and then no worse than it was. Calls moves(v, place) for each before
  // it does: where in its ball it will be. Sets changed[tet] to 1 for its tetrahedra. Returns how
  // many have moved.
  template <class Moves>
  std::size_t move(double floor, std::uint8_t* changed, const Moves& moves);

  // Bytes that takes for so many tetrahedra.
  static std::uint64_t memory(std::uint64_t tets);

 private:
  Point3 step(VertexId v, const PositionWish& wish) const;
  bool find_position(VertexId v, const Point3& step, double floor, Vec3<Real>* position) const;
  bool keeps_shapes(VertexId v, const Vec3<Real>& position, double floor) const;
  PlaceInTet in_ball(VertexId v, const Vec3<Real>& position) const;

  WorkMesh<Real>* mesh_ = nullptr;
  const VertexTets* balls_ = nullptr;
  std::span<const VertexId> vertices_;
  Vector<std::uint32_t> index_;  // of each vertex of the mesh, among those; kNoVertex: it stays
  Vector<PositionWish::Component> components_;  // of the one in hand
  Vector<PositionWish> wishes_;
};

template <class Real>
template <class Moves>
std::size_t VertexMoves<Real>::move(double floor, std::uint8_t* changed, const Moves& moves) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const VertexId v = vertices_[i];
    Vec3<Real> position;
    if (!find_position(v, step(v, wishes_[i]), floor, &position)) continue;
    moves(v, in_ball(v, position));
    mesh_->positions[v] = position;
    for (const std::uint32_t entry : balls_->of(v)) changed[entry >> 2] = 1;
    ++count;
  }
  return count;
}

extern template class VertexMoves<float>;
extern template class VertexMoves<double>;

}  // namespace tetfusion
