#include "kernel/fuse/fuse_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/lanes.h"

namespace tetfusion {

namespace {

// What quadrics cannot tell, in single precision: this share of the differences in a cavity.
constexpr double kSingle = 1e-4;

// What a squared error costs at a point that goes; that is only looked at where it is more than so
// many times the round's mean (where fields are smooth, all are off alike).
constexpr double kLossCost = 8;
constexpr double kLossOutlier = 8;
// From this on nothing is dear: single precision has room for more.
constexpr double kLargestThreshold = 1e30;

template <class F>
F load(const double* from) {
  F values;
  std::memcpy(&values, from, sizeof values);
  return values;
}
// What went through memcpy() would be compared outside of the registers for numbers.
template <>
double load<double>(const double* from) {
  return *from;
}

// The least and the most, in the cavity, of kCount values that steer, or of kCount lanes of them,
// from that one on. What is in hand stays in registers. Returns the value after the last.
template <class F, std::size_t kCount, class Real>
std::size_t find_ranges(const WorkMesh<Real>& mesh, const FuseCavity<Real>& cavity,
                        std::size_t first, double* least_out, double* most_out) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double* const steering = mesh.steering.data() + first;
  const std::size_t width = mesh.steering_width;
  struct Range {
    Range() {
      least.fill(F{} + kInfinity);
      most.fill(F{} - kInfinity);
    }
    void add(const std::array<F, kCount>& low, const std::array<F, kCount>& high) {
      for (std::size_t k = 0; k < kCount; ++k) {
        least[k] = low[k] < least[k] ? low[k] : least[k];
        most[k] = most[k] < high[k] ? high[k] : most[k];
      }
    }
    std::array<F, kCount> least, most;
  };
  const auto look = [&](VertexId v, Range* range) {
    std::array<F, kCount> values;
    const double* const row = steering + v * width;
    for (std::size_t k = 0; k < kCount; ++k) values[k] = load<F>(row + k * sizeof(F) / sizeof *row);
    range->add(values, values);
  };
  // Several, as none should wait for the one before.
  Range one, two, three;
  // Those that move are corners of what is deleted.
  for (const std::uint32_t entry : cavity.affected()) {
    const Tet& tet = mesh.tets[entry >> 2];
    look(tet[(entry + 1) & 3u], &one);
    look(tet[(entry + 2) & 3u], &two);
    look(tet[(entry + 3) & 3u], &three);
  }
  for (const TetId t : cavity.deleted()) {
    const Tet& tet = mesh.tets[t];
    look(tet[0], &one);
    look(tet[1], &two);
    look(tet[2], &three);
    look(tet[3], &one);
  }
  one.add(two.least, two.most);
  one.add(three.least, three.most);
  std::memcpy(least_out + first, one.least.data(), sizeof one.least);
  std::memcpy(most_out + first, one.most.data(), sizeof one.most);
  return first + sizeof one.least / sizeof(double);
}

template <class Real>
void find_ranges(const WorkMesh<Real>& mesh, const FuseCavity<Real>& cavity, double* least,
                 double* most) {
  const std::size_t width = mesh.steering_width;
  std::size_t k = 0;
  while (k + 4 <= width) k = find_ranges<DoubleLanes, 2>(mesh, cavity, k, least, most);
  while (k + 2 <= width) k = find_ranges<DoubleLanes, 1>(mesh, cavity, k, least, most);
  if (k < width) find_ranges<double, 1>(mesh, cavity, k, least, most);
}

}  // namespace

template <class Real>
void FuseValues<Real>::begin(const FuseLimits& limits, std::span<const SteeringField> fields,
                             WorkMesh<Real>* mesh, LiveBalls* balls, EdgeCosts<Real>* edge_costs) {
  limits_ = &limits;
  mesh_ = mesh;
  edge_costs_ = edge_costs;
  width_ = mesh->steering_width;
  paper_.begin(limits.paper, fields, mesh);
  integrals_.begin(limits.keep_integrals, fields, limits.regions, mesh);
  errors_.begin(fields, {limits.max_error, limits.error_now, limits.unit, limits.max_deviation},
                mesh, balls);
  values_.resize(width_);
  least_.resize(width_);
  most_.resize(width_);
  losses_ = 0;
  fused_ = 0;
}

template <class Real>
std::optional<Reject> FuseValues<Real>::judge(const Joining<Real>& joining,
                                              const MergedQuadric& merged,
                                              const FuseCavity<Real>& cavity) {
  if (joining.fixed) {
    std::copy_n(mesh_->steering.data() + joining.partner * width_, width_, values_.begin());
    least_ = most_ = values_;
  } else {
    choose(joining, merged, cavity);
  }
  if (integrals_.stay()) {
    if (!integrals_.find(joining, values_)) return Reject::kIntegral;
    least_ = most_ = values_;
  }
  if (errors_.bounds() && !errors_.allows(joining, least_, most_, values_)) {
    return Reject::kDeviation;
  }
  return paper_.judge(joining, values_);
}

template <class Real>
void FuseValues<Real>::choose(const Joining<Real>& joining, const MergedQuadric& merged,
                              const FuseCavity<Real>& cavity) {
  const auto& [v, partner, fixed, position, affected, deleted] = joining;
  interpolation_ = cavity.interpolation();
  const Offset u = edge_costs_->offset(mesh_->positions[v], position);
  const double* steering = mesh_->steering.data();
  find_ranges(*mesh_, cavity, least_.data(), most_.data());
  for (std::size_t k = 0; k < width_; ++k) {
    const double least = least_[k], most = most_[k];
    const double before = interpolate(interpolation_, steering, width_, k);
    const double best = best_at(merged, v, u, k);
    const bool same = std::abs(best - before) <= kSingle * (most - least);
    values_[k] = same ? before : std::clamp(best, least, most);
  }
}

// By the quadrics of the two: what value k should be there.
template <class Real>
double FuseValues<Real>::best_at(const MergedQuadric& merged, VertexId v, const Offset& u,
                                 std::size_t k) const {
  return mesh_->steering[v * width_ + k] +
         double{best_value(merged.sum.data(), k, u)} / edge_costs_->scale(k);
}

template <class Real>
std::optional<float> FuseValues<Real>::find_loss(const Joining<Real>& joining,
                                                 const MergedQuadric& merged,
                                                 const FuseCavity<Real>& cavity, float weight) {
  loss_ = 0;
  const double threshold = limits_->threshold;
  if (width_ == 0 || !(threshold < kLargestThreshold) || errors_.bounds()) return std::nullopt;
  if (joining.fixed) {
    std::copy_n(mesh_->steering.data() + joining.partner * width_, width_, values_.begin());
  } else {
    const Offset u = edge_costs_->offset(mesh_->positions[joining.v], joining.position);
    for (std::size_t k = 0; k < width_; ++k) values_[k] = best_at(merged, joining.v, u, k);
  }
  const auto too_dear = [&](VertexId x, const typename FuseCavity<Real>::Place& place) {
    const double cost = kLossCost * loss_at(x, place) * double{weight};
    loss_ = std::max(loss_, std::min(cost, threshold));
    const bool is_outlier =
        cost > threshold && !(cost * static_cast<double>(fused_) < kLossOutlier * losses_);
    // Rounded up, so that it is above the threshold, too.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const auto single = static_cast<float>(std::min(cost, kLargestThreshold));
    return is_outlier ? std::optional(std::nextafter(single, kInfinity)) : std::nullopt;
  };
  if (const auto dear = too_dear(joining.v, cavity.place_of_vertex())) return dear;
  if (joining.fixed) return std::nullopt;
  return too_dear(joining.partner, cavity.place_of_partner());
}

// The square of the error at a vertex that goes.
template <class Real>
double FuseValues<Real>::loss_at(VertexId x, const typename FuseCavity<Real>::Place& place) const {
  const double* steering = mesh_->steering.data();
  double squares = 0;
  for (std::size_t k = 0; k < width_; ++k) {
    double value = place.shares[0] * values_[k];
    for (std::size_t i = 0; i < 3; ++i) {
      value += place.shares[i + 1] * steering[place.base[i] * width_ + k];
    }
    const double error = (value - steering[x * width_ + k]) * edge_costs_->scale(k);
    squares += error * error;
  }
  return squares;
}

template <class Real>
double FuseValues<Real>::error(float cost) const {
  return errors_.bounds_all() ? errors_.largest_error(values_) : std::sqrt(std::max(cost, 0.0F));
}

template <class Real>
void FuseValues<Real>::apply(VertexId kept) {
  if (errors_.bounds()) errors_.apply();
  if (integrals_.stay()) integrals_.apply(kept, interpolation_);
  losses_ += loss_;
  ++fused_;
}

template class FuseValues<float>;
template class FuseValues<double>;

}  // namespace tetfusion
