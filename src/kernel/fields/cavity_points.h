// The original's points in the cavity of a fusion, and where they lie once it is done.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/joining.h"
#include "kernel/live_balls.h"
#include "kernel/point3.h"
#include "kernel/sheets/near_surface.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class CavityPoints {
 public:
  struct Point {
    Vec3<Real> position;
    const double* values;  // the original's, of all fields that steer
    std::uint32_t id;      // kNoPoint: still a vertex
    std::uint32_t near;    // in this one of the fan it is, or was, or next to it
  };
  // An affected tetrahedron as it will be: rows times the offset from the new vertex, in the unit,
  // are the weights of its other corners.
  struct FanTet {
    std::array<std::array<double, 3>, 3> rows;
    double rounding;  // of a weight, at most
    double longest;
    std::array<VertexId, 3> corners;
    TetId tet;
  };
  // A point in a tetrahedron of the fan, or on the surface; next to a face there may be two or more
  // of one point.
  struct Place {
    std::uint32_t point, fan_tet;
    std::array<double, 4> weights;  // the new vertex first
    double depth;                   // the deepest place is the one that remembers the point
    double off;                     // the weights may be wrong by so much
  };

  // The mesh's removed points are wanted from here on. `unit` is that of lengths, as in
  // begin_quadrics(); sheets move by `max_deviation` in the unit, or stay where that is negative.
  // Mesh and balls outlive this.
  void begin(double unit, double max_deviation, WorkMesh<Real>* mesh, LiveBalls* balls);

  // Takes that fusion in hand, without places: its points, if it is not that of the same two, and
  // its tetrahedra, of positive volume all around.
  void set(const Joining<Real>& joining);
  // The same, also where the points of the same two are known: they are others by now.
  void set_anew(const Joining<Real>& joining) {
    joining_ = {};
    set(joining);
  }
  const Joining<Real>& joining() const { return joining_; }

  // Adds the places of a point: one in every tetrahedron that it is not certainly outside of, so
  // that what holds of them holds whichever somebody finds it in. False if nobody can tell.
  bool locate(std::uint32_t point);
  // It comes first until there are others.
  void put_first(std::uint32_t point);
  // Would points outside that are nearest to what is next to the cavity be that still?
  bool spares_neighbours();

  const Vector<Point>& points() const { return points_; }
  const Vector<Place>& places() const { return places_; }
  const Point& point(const Place& place) const { return points_[place.point]; }
  const FanTet& tet(const Place& place) const { return fan_[place.fan_tet]; }
  // All affected tetrahedra. None: nothing is left that could hold a point.
  std::span<const FanTet> tets() const { return std::span(fan_.data(), affected_); }
  const Vec3<double>& centre() const { return centre_; }  // the position of the new vertex
  double unit() const { return unit_; }

  // To be called before the mesh changes, when all points of the fusion in hand have places: both
  // vertices' points, if they are still those of the original, are removed ones from here on, and
  // all are in the tetrahedra that will hold them.
  void apply();
  // Where the fusion in hand is not done: what is known of the surface round it.
  void forget_surface() { surface_.forget(); }

 private:
  using Weights = std::array<double, 4>;

  void collect(const Joining<Real>& joining);
  void add_vertex(VertexId v);
  void add_list(TetId t, std::uint32_t near);
  void make_fan(const Joining<Real>& joining);
  Weights weights_at(const FanTet& tet, const Vec3<Real>& p) const;
  void add_place(std::uint32_t point, std::uint32_t fan_tet, const Weights& weights, double least);
  void add_place_on(const typename NearSurface<Real>::Hit& hit, std::uint32_t point);
  bool find_outside(std::uint32_t point, std::uint32_t nearest, double least);
  double file_rounding(const Vec3<Real>& p) const;

  WorkMesh<Real>* mesh_ = nullptr;
  std::size_t width_ = 0;
  double unit_ = 1;
  Joining<Real> joining_;
  NearSurface<Real> surface_;
  std::vector<typename NearSurface<Real>::Hit> hits_;
  Vector<Point> points_;
  Vector<FanTet> fan_;  // then faces of others that points outside are nearest to
  std::uint32_t affected_ = 0;
  Vector<Place> places_;
  Vec3<double> centre_{};
};

extern template class CavityPoints<float>;
extern template class CavityPoints<double>;

}  // namespace tetfusion
