// Values of new vertices, fitted to what the original has at the points that are gone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/vector.h"
#include "kernel/criteria.h"
#include "kernel/fit/tet_walk.h"
#include "kernel/fit/vertex_moves.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Of the original.
template <class Real>
struct PointsToFit {
  std::span<const Vec3<Real>> positions;
  // Where to begin to look for them: inside of the mesh, on the side of a crack where they belong.
  // Empty: at the points themselves, all of which are inside.
  std::span<const Vec3<Real>> starts;
};

// Which vertices may be moved, and for what.
struct MoveLimits {
  // Of these fields errors count, as shares of their ranges. Each has a column that is fitted.
  // Empty: nothing moves.
  std::vector<SteeringField> fields;
  double floor = 0;                   // of shapes: a mean ratio
  std::vector<std::uint32_t> labels;  // columns of cells: what lies between others stays
};

// Fusing chooses a value by the gradients that were where the vertices came from, or interpolates,
// again and again; what the mesh makes of it at points between vertices is only known when all is
// done (README.md).
//
// Begin with a mesh, add points, and fit; keeps its scratch memory; one a thread.
template <class Real>
class ValueFit {
 public:
  // The mesh is not changed until fit(), and outlives that, as does the walk, which has begun with
  // it. The columns are some of those of its points, of floating-point numbers.
  void begin(WorkMesh<Real>* mesh, std::span<const std::uint32_t> columns, TetWalk<Real>* walk);

  // Every step-th of these points, from that one on. Neighbours are best near each other in the
  // list. Points outside of the mesh do not count, unless they have starts and are not far outside:
  // then they do in the mean, as a tetrahedron nearby goes on there.
  void add(const PointsToFit<Real>& points, std::uint64_t first, std::uint64_t step);

  // Calls use(rows) with the rows that the points of each add() have of one of the columns, the
  // first being 0; as often as it is called itself.
  using UseRows = std::function<void(const std::byte* rows)>;
  using ReadRows = std::function<void(std::size_t column, const UseRows& use)>;

  // Moves vertices inside of the mesh that were fused to new places, so that the errors are
  // smaller, and their values with them; finds the points again. Calls again(take), for which
  // take(points) is to be called as add() was.
  using TakePoints = std::function<void(const PointsToFit<Real>& points)>;
  void move(const MoveLimits& limits, const ReadRows& read,
            const std::function<void(const TakePoints& take)>& again);

  // Fits the values of the vertices that were fused to new places, and that no other chunk has, one
  // component after another: first for small squares of the errors at the points, then for a small
  // largest one. None leaves the range of its own value and those of the points in the tetrahedra
  // round it; a linear field stays what it is, to rounding. Values that are not finite do not
  // count. A function of the mesh and the points.
  void fit(const ReadRows& read);

  // Bytes that takes beside the mesh and the walk, for so many points and tetrahedra.
  static std::uint64_t memory(std::uint64_t points, std::uint64_t tets);

 private:
  using Place = typename TetWalk<Real>::Place;
  // A vertex's values may lie between these; what the points' errors ask for, and how loudly.
  struct Move {
    double least, most;
    double sum, weight;
  };

  bool depends_on_new(const Place& place) const;
  void for_each_component(std::size_t c, const ReadRows& read, const std::function<void()>& use);
  template <class T, class Use>
  void for_each_component_of(Column* column, std::size_t c, const ReadRows& read, const Use& use);
  void choose_movable(const MoveLimits& limits);
  void note_errors(double scale);
  void take_values_along(VertexId v, const PlaceInTet& place);
  void find_again(std::size_t piece, const PointsToFit<Real>& points);
  Point3 gradient_in(TetId tet) const;
  void fit_values();
  void approach(int steps);
  void find_ranges();
  double error_at(std::size_t i) const;
  double sweep(double bound);
  void move_values(double full_weight);

  WorkMesh<Real>* mesh_ = nullptr;
  TetWalk<Real>* walk_ = nullptr;
  std::vector<std::uint32_t> columns_;
  Vector<std::uint8_t> may_change_;     // of each vertex
  Vector<VertexId> vertices_;           // those that may
  Vector<Place> places_;                // of points on which such vertices have influence
  Vector<std::uint32_t> row_of_place_;  // of these, where each was added
  Vector<std::size_t> ends_;            // of each add(), how many places there were then
  // Of the component in hand:
  Vector<double> goals_;   // at each place
  Vector<double> values_;  // of each vertex
  Vector<Move> moves_;     // of each vertex
  // Of vertices that move:
  VertexMoves<Real> vertex_moves_;
  Vector<VertexId> movable_;
  Vector<std::uint8_t> changed_;  // of each tetrahedron: has a corner moved?
};

extern template class ValueFit<float>;
extern template class ValueFit<double>;

}  // namespace tetfusion
