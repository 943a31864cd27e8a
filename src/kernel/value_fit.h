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
#include "kernel/tet_walk.h"
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
  template <class T>
  void fit_column(Column* column, const std::function<void(const UseRows& use)>& read);
  void fit_values();
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
};

extern template class ValueFit<float>;
extern template class ValueFit<double>;

}  // namespace tetfusion
