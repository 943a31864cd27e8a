// The tetrahedra round two vertices that are to become one, and whether they may.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fusions.h"
#include "kernel/live_balls.h"
#include "kernel/quadrics/quadric.h"
#include "kernel/shapes/ball_shapes.h"
#include "kernel/shapes/shape_grades.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from cavity to cavity. Not thread-safe.
template <class Real>
class FuseCavity {
 public:
  // The mesh and its balls outlive this; between two fusions only note_fused() changes them. What
  // the mesh remembers of tetrahedra are their grades, noted when they are first looked at. See
  // FuseLimits for the rest.
  void begin(WorkMesh<Real>* mesh, LiveBalls* balls, double min_quality, double unit);

  // Collects the cavity of v and its neighbour, which come together at the position; a partner that
  // is fixed is there already, and the tetrahedra round it stay as they are. (A vertex that goes
  // there by itself has kNoVertex for such a one.) Gives the reason if they may not: an affected
  // tetrahedron would turn over, or be worse than the floor; it may be so where the vertex that it
  // comes from has one below the floor, but no worse than the cavity's worst grade
  // (shape_grades.h). The lists are of use after no reason alone.
  std::optional<Reject> collect(VertexId v, VertexId partner, bool fixed,
                                const Vec3<Real>& position);

  // After collect(): where v, or a partner that is not fixed, is now, as it will be in the new
  // mesh: shares of the new vertex and of the corners of a base triangle.
  struct Place {
    std::array<VertexId, 3> base;
    std::array<double, 4> shares;
    double least() const { return *std::min_element(shares.begin(), shares.end()); }
  };
  Place place_of_vertex() const { return find_place(of_vertex_.shapes, partner_); }
  Place place_of_partner() const {
    return find_place(of_partner_.shapes, of_vertex_.shapes.vertex());
  }

  // What spoke against the last position, if that may not be.
  TetId refused_by() const { return failed_ >> 2; }
  // That tetrahedron would be valid if the position went so far, in the unit of the limits, along
  // the direction, which has unit length.
  struct Obstacle {
    Offset direction;
    float distance;
  };
  Obstacle obstacle() const;

  // To be called when the cavity has been fused, with the vertex that it was fused into.
  void note_fused(VertexId kept);

  // tet << 2 | corner of the vertex that moves.
  std::span<const std::uint32_t> affected() const { return affected_; }
  std::span<const TetId> deleted() const { return deleted_; }

  // After collect(): the tetrahedron of the cavity, as it is now, that has the position.
  Interpolation interpolation() const;

 private:
  // How bad a tetrahedron may be, as a cubed mean ratio.
  struct Limit {
    double least = 0;
    double sure = 0;     // no less, and the sign of a volume is beyond doubt
    ShapeFloors shapes;  // the same, with some room
  };
  Limit limit_of(double least) const;
  struct Ball {
    BallShapes<Real> shapes;
    std::optional<std::uint8_t> grade;  // the worst in it, as far as is known
  };
  Ball& ball_of(VertexId v, Ball* ball);
  std::uint8_t grade_of(Ball* ball);
  double cubed_mean_ratio(const Tet& tet) const;
  bool lower_limit(Ball* ball);
  std::optional<Reject> judge_ball(Ball* ball, VertexId other);
  std::optional<Reject> judge_group(const BallShapes<Real>& ball, std::size_t first,
                                    const typename BallShapes<Real>::LocalPosition& local,
                                    const LaneMask& good);
  std::optional<Reject> judge_shape(std::uint32_t entry) const;
  Place find_place(const BallShapes<Real>& ball, VertexId other) const;
  Place place_in(std::uint32_t entry, const Vec3<Real>& x) const;
  void list();
  VertexId nearer() const;

  WorkMesh<Real>* mesh_ = nullptr;
  LiveBalls* balls_ = nullptr;
  double unit_ = 1;
  ShapeGrades grades_;
  Limit floor_;             // where nothing is worse
  Limit limit_;             // of the ball that is looked at
  std::uint8_t grade_ = 0;  // the worst that the last cavity was allowed
  GridPositions<Real> grid_;
  VertexId partner_ = kNoVertex;
  Vec3<Real> position_{};
  Ball of_vertex_, of_partner_;
  Vector<bool> has_none_bad_;  // of vertices: no tetrahedron round it is below the floor
  bool fixed_ = false;
  std::uint32_t failed_ = 0;  // the entry that spoke against the last position
  Vector<std::uint32_t> affected_;
  Vector<TetId> deleted_;
};

extern template class FuseCavity<float>;
extern template class FuseCavity<double>;

}  // namespace tetfusion
