// Of fuse_round.h: the values of the new vertex.
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
  const auto look = [&](TetId t) {
    for (const VertexId c : mesh.tets[t]) {
      const double* const values = steering + c * width;
      for (std::size_t k = 0; k < kCount; ++k) {
        F value;
        std::memcpy(&value, values + k * sizeof value / sizeof(double), sizeof value);
        least[k] = value < least[k] ? value : least[k];
        most[k] = most[k] < value ? value : most[k];
      }
    }
  };
  for (const std::uint32_t entry : cavity.affected()) look(entry >> 2);
  for (const TetId t : cavity.deleted()) look(t);
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
  const MergedQuadric& merged = edge_costs_.merged();
  const Offset u = edge_costs_.offset(mesh_->positions[v], position_);
  const double* steering = mesh_->steering.data();
  find_ranges(*mesh_, cavity_, least_.data(), most_.data());
  for (std::size_t k = 0; k < width_; ++k) {
    const double least = least_[k], most = most_[k];
    const double before = interpolate(interpolation_, steering, width_, k);
    const double best = steering[v * width_ + k] +
                        double{best_value(merged.sum.data(), k, u)} / edge_costs_.scale(k);
    const bool same = std::abs(best - before) <= kSingle * (most - least);
    values_[k] = same ? before : std::clamp(best, least, most);
  }
}

template std::optional<Reject> FuseRound<float>::judge_values(VertexId, VertexId);
template std::optional<Reject> FuseRound<double>::judge_values(VertexId, VertexId);
template void FuseRound<float>::choose_values(VertexId, VertexId);
template void FuseRound<double>::choose_values(VertexId, VertexId);

}  // namespace tetfusion
