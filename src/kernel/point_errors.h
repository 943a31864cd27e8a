// A bound on the error at every point of the original mesh: a fusion is allowed if the new cavity's
// fields, at the points that lie in it, are as near to the original's as they must be.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Two neighbours that are to become one.
template <class Real>
struct Joining {
  VertexId v = kNoVertex, partner = kNoVertex;
  bool fixed = false;  // the partner stays where it is, and as it is
  Vec3<Real> position{};
  std::span<const std::uint32_t> affected;  // tet << 2 | corner of the vertex that moves
  std::span<const TetId> deleted;
};

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class PointErrors {
 public:
  // A field's error may be its tolerance at most, or `max_error` where it has none; both are shares
  // of its range, and infinity is no bound. The mesh's removed points are wanted from here on, if
  // there is a bound. Mesh and fields outlive this; `unit` is that of begin_quadrics().
  void begin(std::span<const SteeringField> fields, double max_error, double unit,
             WorkMesh<Real>* mesh);

  // Is there any bound?
  bool bounds() const { return bounds_; }

  // Says whether all bounds hold in the cavity when the two are one, of positive volume all around,
  // with these values; they may be moved, as little as it takes, from `low` to `high` (which are
  // the values of a partner that is fixed). Those that it leaves are as they will be written.
  bool allows(const Joining<Real>& joining, std::span<const double> low,
              std::span<const double> high, std::span<double> values);

  // To be called before the mesh changes, with what allows() has allowed last: both vertices'
  // points, if they are still those of the original, are removed ones from here on, and all are in
  // the tetrahedra that will hold them.
  void apply(VertexId kept);

 private:
  // A field with a bound, in its own unit.
  struct Bound {
    std::uint32_t first, count;
    double range;
    double limit;
    int exponent;
    bool is_float;  // written in single precision
  };
  struct Point {
    Vec3<Real> position;
    const double* values;
    std::uint32_t id;  // kNoPoint: still a vertex
    VertexId vertex;
  };
  // An affected tetrahedron as it will be: rows times the offset from the new vertex are the
  // weights of its other corners.
  struct FanTet {
    std::array<std::array<double, 3>, 3> rows;
    double rounding;  // of a weight, at most
    std::array<VertexId, 3> corners;
    TetId tet;
  };
  // A point in a tetrahedron of the fan; next to a face there may be two or more of one point.
  struct Place {
    std::uint32_t point, fan_tet;
    std::array<double, 4> weights;  // the new vertex first
    double least;                   // of the weights, before they were made to be a share
  };
  using Weights = std::array<double, 4>;

  void collect(const Joining<Real>& joining);
  void add_vertex(VertexId v);
  void add_list(TetId t);
  void make_fan(const Joining<Real>& joining);
  Weights weights_at(const FanTet& tet, const Vec3<Real>& p) const;
  void add_place(std::uint32_t point, std::uint32_t fan_tet, const Weights& weights, double least);
  void find_places(std::uint32_t point);
  bool narrow(const Place& place);
  bool choose(std::span<double> values);
  void draw(const Bound& bound, std::span<double> values);
  double error_at(const Place& place, const Bound& bound, std::span<const double> values,
                  double* differences) const;
  double limit_at(const Place& place, const Bound& bound) const;
  bool holds(std::span<const double> values) const;

  WorkMesh<Real>* mesh_ = nullptr;
  std::size_t width_ = 0;
  double unit_ = 1;
  bool bounds_ = false;
  std::vector<Bound> fields_;

  Joining<Real> joining_;
  Vector<Point> points_;  // those that spoke against the last attempts come first
  Vector<FanTet> fan_;
  Vector<Place> places_;
  Vec3<double> centre_{};
  std::uint32_t last_tet_ = 0;
  std::vector<double> low_, high_, differences_;
};

extern template class PointErrors<float>;
extern template class PointErrors<double>;

}  // namespace tetfusion
