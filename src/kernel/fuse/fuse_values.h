// The values of the vertex that two become, and what they do to the fields.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fields/field_integrals.h"
#include "kernel/fields/point_errors.h"
#include "kernel/fuse/fuse_cavity.h"
#include "kernel/fuse/fuse_limits.h"
#include "kernel/fusions.h"
#include "kernel/joining.h"
#include "kernel/live_balls.h"
#include "kernel/paper_bounds.h"
#include "kernel/quadrics/edge_costs.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Of one pair after the other; the cavity is that of the pair, which has been found to be allowed,
// and where both vertices move `merged` has their quadrics. Keeps its memory from mesh to mesh. Not
// thread-safe.
template <class Real>
class FuseValues {
 public:
  // All outlive this.
  void begin(const FuseLimits& limits, std::span<const SteeringField> fields, WorkMesh<Real>* mesh,
             LiveBalls* balls, EdgeCosts<Real>* edge_costs);

  // Is there a bound on the error at points?
  bool have_bounds() const { return errors_.bounds(); }
  // May values speak against a fusion?
  bool may_refuse() const { return errors_.bounds() || paper_.any() || integrals_.stay(); }

  // A quadric knows how far the new vertex is from the fields that it stands for, but not what its
  // tetrahedra are to the points that go: where a field bends, long ones cut the corner. If the new
  // fields are so far off at one of the two places that the fusion should cost more than the round
  // may: what it should cost, above the threshold. `weight` multiplies costs. (Bounds look at more
  // points than these.)
  std::optional<float> find_loss(const Joining<Real>& joining, const MergedQuadric& merged,
                                 const FuseCavity<Real>& cavity, float weight);

  // Chooses the best values within those of the cavity, or the old fields' own, where the best are
  // the same but for single precision. The partner moves.
  void choose(const Joining<Real>& joining, const MergedQuadric& merged,
              const FuseCavity<Real>& cavity);
  // The same of any partner, as far as bounds leave a choice, and what speaks against them.
  std::optional<Reject> judge(const Joining<Real>& joining, const MergedQuadric& merged,
                              const FuseCavity<Real>& cavity);

  // Bounds speak against most of what is refused in the end. May vertices get better values and
  // places meanwhile, so that they leave more room? For that is PointErrors::refit() and what
  // follows there.
  bool may_refit() const { return errors_.bounds() && !paper_.any() && !integrals_.stay(); }
  bool refit(VertexId v, std::span<const std::uint32_t> ball) {
    return errors_.refit(v, ball, values_);
  }
  // None where a field has no bound, as nothing tells what its value should be there.
  std::optional<Vec3<Real>> wished_position() {
    return errors_.bounds_all() ? errors_.wished_position() : std::nullopt;
  }
  // In a cavity of that vertex alone.
  bool refit_at(const Vec3<Real>& position, const FuseCavity<Real>& cavity) {
    interpolation_ = cavity.interpolation();
    for (std::size_t k = 0; k < width_; ++k) {
      values_[k] = interpolate(interpolation_, mesh_->steering.data(), width_, k);
    }
    return errors_.refit_at(position, cavity.affected(), values_);
  }
  // To be called before the mesh changes, with what refit_at() has found.
  void apply_refit() { errors_.apply(); }

  // As choose(), judge(), refit() or refit_at() has left them.
  std::span<const double> values() const { return values_; }
  const Interpolation& interpolation() const { return interpolation_; }
  // For those who go back: the error at the points, if all fields have bounds there; else the root
  // of what the fusion costs.
  double error(float cost) const;

  // To be called before the mesh changes, when the pair is about to become one.
  void apply(VertexId kept);

  // When no more pairs come.
  void finish() { integrals_.finish(); }

 private:
  double best_at(const MergedQuadric& merged, VertexId v, const Offset& u, std::size_t k) const;
  double loss_at(VertexId x, const typename FuseCavity<Real>::Place& place) const;

  const FuseLimits* limits_ = nullptr;
  const WorkMesh<Real>* mesh_ = nullptr;
  EdgeCosts<Real>* edge_costs_ = nullptr;
  std::size_t width_ = 0;
  PointErrors<Real> errors_;
  PaperBounds<Real> paper_;
  FieldIntegrals<Real> integrals_;

  std::vector<double> values_, least_, most_;  // of the new vertex; the cavity's, now
  Interpolation interpolation_;
  double loss_ = 0;  // what the errors at the two points cost, at most the threshold
  // Of all that were fused.
  double losses_ = 0;
  std::uint64_t fused_ = 0;
};

extern template class FuseValues<float>;
extern template class FuseValues<double>;

}  // namespace tetfusion
