// A bound on the error at every point of the original mesh: a fusion is allowed if the new cavity's
// fields, at the points that lie in it, are as near to the original's as they must be.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fields/cavity_points.h"
#include "kernel/joining.h"
#include "kernel/position_wish.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

struct PointLimits {
  // A field's error may be its tolerance at most, or this where it has none; both are shares of its
  // range, and infinity is no bound.
  double max_error = std::numeric_limits<double>::infinity();
  double error_now = std::numeric_limits<double>::infinity();  // nor may it be more than this
  double unit = 1;                                             // of lengths, as in begin_quadrics()
  double max_deviation = -1;  // so far may sheets move, in the unit; negative: they stay
};

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class PointErrors {
 public:
  // The mesh's removed points are wanted from here on, if there is a bound. Mesh, balls and fields
  // outlive this.
  void begin(std::span<const SteeringField> fields, const PointLimits& limits, WorkMesh<Real>* mesh,
             LiveBalls* balls);

  // Is there any bound? Has every field one?
  bool bounds() const { return bounds_; }
  bool bounds_all() const { return bounds_all_; }

  // Says whether all bounds hold in the cavity when the two are one, of positive volume all around,
  // with these values; they may be moved, as little as it takes, from `low` to `high` (which are
  // the values of a partner that is fixed). Those that it leaves are as they will be written.
  bool allows(const Joining<Real>& joining, std::span<const double> low,
              std::span<const double> high, std::span<double> values);

  // The same of a vertex alone inside of the mesh, which was fused to its place and has this ball:
  // finds values with which the errors at the points round it are smaller in the mean of squares.
  // They stay within the range of its own and of what these points have. False where it should keep
  // its own.
  bool refit(VertexId v, std::span<const std::uint32_t> ball, std::span<double> values);
  // Then, with what values the mesh has by now: where it should rather be.
  std::optional<Vec3<Real>> wished_position();
  // Then, of such a place, or another one where no tetrahedron turns over, with the values that the
  // mesh has there now: finds others with which the errors are smaller. False if there are none.
  bool refit_at(const Vec3<Real>& position, std::span<const std::uint32_t> ball,
                std::span<double> values);

  // Of what allows() has allowed last, with the values that it has left: the largest error at a
  // point of the cavity, as a share of a field's range, whoever evaluates it.
  double largest_error(std::span<const double> values) const;

  // To be called before the mesh changes, with what allows() or refit_at() has allowed last.
  void apply() { cavity_.apply(); }

 private:
  // A field with a bound, in its own unit.
  struct Bound {
    std::uint32_t first, count;
    double range;
    double limit;
    int exponent;
    bool is_float;  // written in single precision
  };
  using Place = typename CavityPoints<Real>::Place;
  using FanTet = typename CavityPoints<Real>::FanTet;

  bool narrow(const Place& place);
  template <std::size_t kAtOnce>
  bool narrow_some(const Place& place, std::size_t first);
  bool choose(std::span<double> values);
  bool fit(std::span<double> values);
  void approach(const Bound& bound, std::span<double> values);
  PositionWish::Component wish_of(std::size_t k) const;
  void draw(const Bound& bound, std::span<double> values);
  double error_at(const Place& place, const Bound& bound, std::span<const double> values,
                  double* differences) const;
  double limit_at(const Place& place, const Bound& bound) const;
  bool holds(std::span<const double> values) const;

  WorkMesh<Real>* mesh_ = nullptr;
  std::size_t width_ = 0;
  bool bounds_ = false, bounds_all_ = false;
  std::vector<Bound> fields_;
  CavityPoints<Real> cavity_;   // points that spoke against the last attempts come first
  bool are_all_known_ = false;  // of refit(): has every point a place?
  double squares_ = 0;          // of errors, where a vertex is that may be moved
  std::vector<double> low_, high_, differences_, sums_;
  // Of each value that steers: what its error may be, and what that loses where weights are off by
  // 1. Without bound, and not to be narrowed, are vectors' components.
  std::vector<double> limits_, losses_;
};

extern template class PointErrors<float>;
extern template class PointErrors<double>;

}  // namespace tetfusion
