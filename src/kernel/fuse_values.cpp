// Of fuse_round.h: the values of the new vertex, and what they do to the fields.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/lanes.h"
#include "kernel/fuse_round.h"

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
  std::array<F, kCount> least, most;
  least.fill(F{} + kInfinity);
  most.fill(F{} - kInfinity);
  const auto look = [&](VertexId v) {
    const double* const values = steering + v * width;
    for (std::size_t k = 0; k < kCount; ++k) {
      const F value = load<F>(values + k * sizeof(F) / sizeof(double));
      least[k] = value < least[k] ? value : least[k];
      most[k] = most[k] < value ? value : most[k];
    }
  };
  // Those that move are corners of what is deleted.
  for (const std::uint32_t entry : cavity.affected()) {
    for (std::uint32_t i = 1; i < 4; ++i) look(mesh.tets[entry >> 2][(entry + i) & 3u]);
  }
  for (const TetId t : cavity.deleted()) {
    for (const VertexId v : mesh.tets[t]) look(v);
  }
  std::memcpy(least_out + first, least.data(), sizeof least);
  std::memcpy(most_out + first, most.data(), sizeof most);
  return first + sizeof least / sizeof(double);
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

// Chooses the values, too, as far as the bounds leave a choice.
template <class Real>
std::optional<Reject> FuseRound<Real>::judge_values(VertexId v, VertexId partner) {
  const Joining<Real> joining{v, partner, fixed_, position_, cavity_.affected(), cavity_.deleted()};
  if (fixed_) {
    std::copy_n(mesh_->steering.data() + partner * width_, width_, values_.begin());
    least_ = most_ = values_;
  } else {
    choose_values(v, partner);
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

// The best values within those of the cavity, or the old fields' own, where the best are the same
// but for single precision.
template <class Real>
void FuseRound<Real>::choose_values(VertexId v, VertexId partner) {
  interpolation_ = cavity_.interpolation(v, partner, position_);
  const Offset u = edge_costs_.offset(mesh_->positions[v], position_);
  const double* steering = mesh_->steering.data();
  find_ranges(*mesh_, cavity_, least_.data(), most_.data());
  for (std::size_t k = 0; k < width_; ++k) {
    const double least = least_[k], most = most_[k];
    const double before = interpolate(interpolation_, steering, width_, k);
    const double best = best_at(v, u, k);
    const bool same = std::abs(best - before) <= kSingle * (most - least);
    values_[k] = same ? before : std::clamp(best, least, most);
  }
}

// By the quadrics of the two: what value k should be there.
template <class Real>
double FuseRound<Real>::best_at(VertexId v, const Offset& u, std::size_t k) const {
  return mesh_->steering[v * width_ + k] +
         double{best_value(edge_costs_.merged().sum.data(), k, u)} / edge_costs_.scale(k);
}

// A quadric knows how far the new vertex is from the fields that it stands for, but not what its
// tetrahedra are to the points that go: where a field bends, long ones cut the corner. Would the
// new fields be so far off at one of the two places that the fusion should cost more than the round
// may? (Bounds look at more points than these.)
template <class Real>
bool FuseRound<Real>::loses_too_much(VertexId v, VertexId partner) {
  loss_ = 0;
  if (width_ == 0 || !(limits_->threshold < kLargestThreshold) || errors_.bounds()) return false;
  const double* steering = mesh_->steering.data();
  if (fixed_) {
    std::copy_n(steering + partner * width_, width_, values_.begin());
  } else {
    const Offset u = edge_costs_.offset(mesh_->positions[v], position_);
    for (std::size_t k = 0; k < width_; ++k) values_[k] = best_at(v, u, k);
  }
  const auto loses = [&](VertexId x, const typename FuseCavity<Real>::Place& place) {
    double squares = 0;
    for (std::size_t k = 0; k < width_; ++k) {
      double value = place.shares[0] * values_[k];
      for (std::size_t i = 0; i < 3; ++i) {
        value += place.shares[i + 1] * steering[place.base[i] * width_ + k];
      }
      const double error = (value - steering[x * width_ + k]) * edge_costs_.scale(k);
      squares += error * error;
    }
    const double cost = kLossCost * squares * double{weight_of(v, partner)};
    loss_ = std::max(loss_, std::min(cost, limits_->threshold));
    if (!(cost > limits_->threshold)) return false;
    if (cost * static_cast<double>(fused_) < kLossOutlier * losses_) return false;
    // Rounded up, so that it is above the threshold, too.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    dear_ = std::nextafter(static_cast<float>(std::min(cost, kLargestThreshold)), kInfinity);
    return true;
  };
  return loses(v, cavity_.place_of_vertex()) ||
         (!fixed_ && loses(partner, cavity_.place_of_partner()));
}

// For those who go back: at the points, if all fields have bounds there; else what the quadric
// says, at the position that was chosen. Rounded up.
template <class Real>
float FuseRound<Real>::error_of(VertexId v, const Candidate& candidate) const {
  double error = 0;
  if (errors_.bounds_all()) {
    error = errors_.largest_error(values_);
  } else {
    float cost = candidate.cost;
    if (!fixed_) {
      const MergedQuadric& merged = edge_costs_.merged();
      const Offset u = edge_costs_.offset(mesh_->positions[v], position_);
      const float weight = is_on_sheet(v) ? 1 : merged.sum[kQuadricW];
      cost = std::max(cost, value_at(merged.reduced, u) / weight * weight_of(v, candidate.partner));
    }
    error = std::sqrt(std::max(cost, 0.0F));
  }
  const auto single = static_cast<float>(error);
  return single < error ? std::nextafter(single, std::numeric_limits<float>::infinity()) : single;
}

template std::optional<Reject> FuseRound<float>::judge_values(VertexId, VertexId);
template std::optional<Reject> FuseRound<double>::judge_values(VertexId, VertexId);
template void FuseRound<float>::choose_values(VertexId, VertexId);
template void FuseRound<double>::choose_values(VertexId, VertexId);
template double FuseRound<float>::best_at(VertexId, const Offset&, std::size_t) const;
template double FuseRound<double>::best_at(VertexId, const Offset&, std::size_t) const;
template bool FuseRound<float>::loses_too_much(VertexId, VertexId);
template bool FuseRound<double>::loses_too_much(VertexId, VertexId);
template float FuseRound<float>::error_of(VertexId, const Candidate&) const;
template float FuseRound<double>::error_of(VertexId, const Candidate&) const;

}  // namespace tetfusion
