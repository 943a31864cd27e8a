#include "kernel/fuse_round.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace tetfusion {

namespace {

// A round is over when a pass has fused less than this share of the vertices.
constexpr double kIdleShare = 0.02;
// See best_position().
constexpr float kPull = 0.02F;
constexpr float kReach = 0.5F;  // of the edge
// What a fusion costs where fields do not tell: the square of the edge, times this. A cell a tenth
// of the mesh's diagonal long is worth an error of 1e-4.
constexpr float kLengthCost = 1e-6F;

bool is_deleted(const Tet& tet) { return tet[0] == kNoVertex; }

// The cubed mean ratio, 432 D^2 / (sum of the squared edges)^3, of the tetrahedron with
// determinant D.
template <class Real>
double cubed_mean_ratio(const std::array<Vec3<Real>, 4>& p, double det, double unit) {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double x = (double{p[j].x} - p[i].x) * unit;
      const double y = (double{p[j].y} - p[i].y) * unit;
      const double z = (double{p[j].z} - p[i].z) * unit;
      sum += x * x + y * y + z * z;
    }
  }
  const double scaled = det * unit * unit * unit;
  return 432 * scaled * scaled / (sum * sum * sum);
}

template <class Real>
std::array<Vec3<Real>, 4> corners(const Vector<Vec3<Real>>& positions, const Tet& t) {
  return {positions[t[0]], positions[t[1]], positions[t[2]], positions[t[3]]};
}

}  // namespace

std::size_t cost_bin(double cost) {
  if (!(cost > 0)) return 0;
  int exponent = 0;
  const double m = std::frexp(cost, &exponent);
  const int bin = 2 * (exponent + 72) + (m >= 0.70710678118654752 ? 1 : 0);
  return static_cast<std::size_t>(std::clamp(bin, 0, static_cast<int>(kCostBins) - 1));
}

double cost_bin_end(std::size_t bin) {
  const int exponent = static_cast<int>(bin / 2) - 72;
  return std::ldexp(bin % 2 == 0 ? 0.70710678118654752 : 1.0, exponent);
}

template <class Real>
void begin_quadrics(std::span<const SteeringField> fields, double unit, WorkMesh<Real>* mesh) {
  const std::size_t width = mesh->steering_width;
  mesh->quadric_width = quadric_row(mesh->steering_width);
  const std::size_t row = mesh->quadric_width;
  mesh->quadrics.assign(mesh->vertex_count() * row, 0.0F);
  std::vector<double> scale(width);
  for (const SteeringField& f : fields) {
    for (std::uint32_t k = 0; k < f.count; ++k) scale[f.first + k] = 1 / f.range;
  }
  std::vector<float> gradients(3 * width);
  for (const Tet& tet : mesh->tets) {
    const Determinant det = determinant(mesh->positions, tet);
    if (!(det.value > det.error)) continue;
    const Vec3<Real>& o = mesh->positions[tet[0]];
    std::array<std::array<double, 3>, 3> e{};  // edges from the first corner, scaled
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3<Real>& p = mesh->positions[tet[i + 1]];
      e[i] = {(double{p.x} - o.x) * unit, (double{p.y} - o.y) * unit, (double{p.z} - o.z) * unit};
    }
    const double volume = det.value * unit * unit * unit;
    const double inverse = 1 / volume;
    const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
      return std::array<double, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                   a[0] * b[1] - a[1] * b[0]};
    };
    const std::array<std::array<double, 3>, 3> dual{cross(e[1], e[2]), cross(e[2], e[0]),
                                                    cross(e[0], e[1])};
    bool finite = true;
    for (std::size_t k = 0; k < width; ++k) {
      const double first = mesh->steering[tet[0] * width + k];
      std::array<double, 3> g{};
      for (std::size_t i = 0; i < 3; ++i) {
        const double rise = (mesh->steering[tet[i + 1] * width + k] - first) * scale[k] * inverse;
        for (std::size_t a = 0; a < 3; ++a) g[a] += rise * dual[i][a];
      }
      for (std::size_t a = 0; a < 3; ++a) {
        gradients[3 * k + a] = static_cast<float>(g[a]);
        finite = finite && std::abs(volume * g[a] * g[a]) < 1e30;
      }
    }
    if (!finite) continue;
    for (const VertexId v : tet) {
      add_tetrahedron(static_cast<float>(volume), gradients.data(), width,
                      mesh->quadrics.data() + v * row);
    }
  }
}

template <class Real>
void FuseRound<Real>::begin(const FuseLimits& limits, std::span<const SteeringField> fields,
                            WorkMesh<Real>* mesh) {
  limits_ = &limits;
  mesh_ = mesh;
  width_ = mesh->steering_width;
  row_ = mesh->quadric_width;
  fields_ = fields;
  std::size_t steering_columns = 0;
  for (const SteeringField& f : fields) steering_columns += f.column != kNoColumn ? 1 : 0;
  interpolates_ = steering_columns < mesh->point_columns.size();
  field_scale_.assign(width_, 0.0F);
  for (const SteeringField& f : fields) {
    for (std::uint32_t k = 0; k < f.count; ++k) {
      field_scale_[f.first + k] = static_cast<float>(1 / f.range);
    }
  }
  sum_.resize(row_);
  shifted_.resize(row_);
  differences_.resize(width_);
  values_.resize(width_);

  const std::size_t n = mesh->vertex_count();
  build_vertex_tets(n, mesh->tets, &start_);
  entries_.resize(start_.entries.size());
  std::copy(start_.entries.begin(), start_.entries.end(), entries_.begin());
  balls_.resize(n);
  kind_.resize(n);
  for (std::size_t v = 0; v < n; ++v) {
    const std::uint32_t count = start_.offsets[v + 1] - start_.offsets[v];
    balls_[v] = {start_.offsets[v], count, count};
    const std::uint8_t marks = mesh->marks[v];
    kind_[v] = (marks & kOnInterface) != 0             ? kOut
               : (marks & (kLocked | kOnBoundary)) != 0 ? kTarget
                                                        : kFree;
    for (std::size_t k = 0; k < width_; ++k) {
      if (!std::isfinite(mesh->steering[v * width_ + k])) kind_[v] = kOut;
    }
  }
  reason_.assign(n, 0);
  candidates_.assign(n, Candidates{});
  now_ = 1;
  changed_.assign(n, 1);
  judged_.assign(n, 0);
  tried_.assign(n, 0);
  moved_.assign(n, 1);
  fused_in_.assign(n, 0);
  stamp_.assign(n, 0);
  stamped_ = 0;
  pass_ = 0;
  removed_ = 0;
  fused_ = 0;
  interpolations_.clear();
}

template <class Real>
FuseStatistics FuseRound<Real>::run(const FuseLimits& limits,
                                    std::span<const SteeringField> fields, WorkMesh<Real>* mesh) {
  begin(limits, fields, mesh);
  FuseStatistics statistics;
  statistics.pass.tets_before = mesh->tets.size();
  for (;;) {
    const std::uint64_t removed_before = removed_;
    const std::uint64_t fused = pass();
    const auto left = static_cast<double>(statistics.pass.tets_before - removed_);
    if (removed_ >= limits.quota || fused == 0 ||
        static_cast<double>(removed_ - removed_before) < kIdleShare * left) {
      break;
    }
  }
  finish(&statistics);
  compact();
  return statistics;
}

template <class Real>
FuseStatistics FuseRound<Real>::look(const FuseLimits& limits,
                                     std::span<const SteeringField> fields, WorkMesh<Real>* mesh) {
  begin(limits, fields, mesh);
  FuseStatistics statistics;
  statistics.pass.tets_before = mesh->tets.size();
  finish(&statistics);
  return statistics;
}

// Costs of what is left, for the next threshold.
template <class Real>
void FuseRound<Real>::finish(FuseStatistics* statistics) {
  statistics->pass.tets_after = statistics->pass.tets_before - removed_;
  statistics->pass.fused = fused_;
  const auto threshold = static_cast<float>(limits_->threshold);
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const auto v = static_cast<VertexId>(i);
    if (mesh_->incidence[v] == 0) continue;
    float* cost = mesh_->quadrics.data() + v * row_ + row_ - 1;
    *cost = 0;
    if (!can_move(v)) {
      const bool interface = (mesh_->marks[v] & kOnInterface) != 0;
      const bool boundary = (mesh_->marks[v] & kOnBoundary) != 0;
      const Reject reason = interface ? Reject::kInterface
                            : boundary ? Reject::kBoundary
                                       : Reject::kLocked;
      ++statistics->pass.rejected[static_cast<std::size_t>(reason)];
      continue;
    }
    if (!knows_candidates(v)) judge(v);
    float least = std::numeric_limits<float>::infinity();
    bool stuck = false;
    for (const Candidate& c : candidates_[v]) {
      if (c.partner == kNoVertex || changed_[c.partner] > judged_[v]) continue;
      if (c.cost <= threshold && tried_[v] >= std::max(moved_[v], moved_[c.partner])) {
        stuck = true;
        continue;
      }
      least = std::min(least, c.cost);
    }
    const bool quota = least <= threshold && removed_ >= limits_->quota;
    const Reject reason = stuck   ? static_cast<Reject>(reason_[v])
                          : quota ? Reject::kQuota
                                  : Reject::kError;
    ++statistics->pass.rejected[static_cast<std::size_t>(reason)];
    if (least < std::numeric_limits<float>::infinity()) ++statistics->costs[cost_bin(least)];
  }
}

template <class Real>
bool FuseRound<Real>::knows_candidates(VertexId v) const {
  return judged_[v] > changed_[v];
}

// A pass; returns its fusions.
template <class Real>
std::uint64_t FuseRound<Real>::pass() {
  ++pass_;
  const std::uint64_t before = fused_;
  const auto threshold = static_cast<float>(limits_->threshold);
  const auto n = static_cast<VertexId>(balls_.size());
  const auto is_due = [&](VertexId v) {
    return can_move(v) && mesh_->incidence[v] != 0 && fused_in_[v] != pass_;
  };
  if (!limits_->cheapest_first) {
    for (VertexId v = 0; v < n && removed_ < limits_->quota; ++v) {
      if (!is_due(v)) continue;
      if (!knows_candidates(v)) judge(v);
      if (candidates_[v][0].cost <= threshold) visit(v);
    }
    return fused_ - before;
  }
  order_.clear();
  for (VertexId v = 0; v < n; ++v) {
    if (!is_due(v)) continue;
    if (!knows_candidates(v)) judge(v);
    if (candidates_[v][0].cost <= threshold) order_.push_back({candidates_[v][0].cost, v});
  }
  std::sort(order_.begin(), order_.end(), [&](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    return mesh_->point_ids[a.second] < mesh_->point_ids[b.second];
  });
  for (const auto& [cost, v] : order_) {
    if (removed_ >= limits_->quota) break;
    if (is_due(v)) visit(v);
  }
  return fused_ - before;
}

// Tries the vertex's candidates under the threshold.
template <class Real>
bool FuseRound<Real>::visit(VertexId v) {
  const Candidates candidates = candidates_[v];
  for (const Candidate& c : candidates) {
    if (c.partner == kNoVertex || !(c.cost <= static_cast<float>(limits_->threshold))) break;
    if (fused_in_[c.partner] == pass_ || changed_[c.partner] > judged_[v]) continue;
    if (tried_[v] >= std::max(moved_[v], moved_[c.partner])) continue;
    if (fuse(v, c.partner)) return true;
    reason_[v] = static_cast<std::uint8_t>(reject_);
  }
  tried_[v] = now_;
  return false;
}

// The tetrahedra round v, without those that are gone.
template <class Real>
std::span<const std::uint32_t> FuseRound<Real>::ball(VertexId v) {
  Ball& b = balls_[v];
  std::uint32_t* entries = entries_.data() + b.begin;
  if (b.count != mesh_->incidence[v]) {
    std::uint32_t live = 0;
    for (std::uint32_t i = 0; i < b.count; ++i) {
      if (!is_deleted(mesh_->tets[entries[i] >> 2])) entries[live++] = entries[i];
    }
    b.count = live;
  }
  return {entries, b.count};
}

template <class Real>
Offset FuseRound<Real>::offset(VertexId from, VertexId to) const {
  const Vec3<Real>&a = mesh_->positions[from], &b = mesh_->positions[to];
  const double unit = limits_->unit;
  return {static_cast<float>((double{b.x} - a.x) * unit),
          static_cast<float>((double{b.y} - a.y) * unit),
          static_cast<float>((double{b.z} - a.z) * unit)};
}

// Chooses the cheapest partners of v. An edge whose other end has been judged since v got its
// quadric is that one's business.
template <class Real>
void FuseRound<Real>::judge(VertexId v) {
  ++stamped_;
  stamp_[v] = stamped_;
  Candidates best{};
  for (const std::uint32_t entry : ball(v)) {
    for (const VertexId u : mesh_->tets[entry >> 2]) {
      if (stamp_[u] == stamped_) continue;
      stamp_[u] = stamped_;
      if (kind_[u] == kOut) continue;
      if (kind_[u] == kFree && judged_[u] > changed_[u] && judged_[u] > changed_[v]) continue;
      Candidate c{cost_of(v, u), u};
      for (Candidate& b : best) {
        if (c.cost < b.cost) std::swap(b, c);
      }
    }
  }
  candidates_[v] = best;
  judged_[v] = ++now_;
}

// What it costs to make v and its neighbour one.
template <class Real>
float FuseRound<Real>::cost_of(VertexId v, VertexId partner) {
  const float* qv = quadric(v);
  const float* qp = quadric(partner);
  const Offset d = offset(v, partner);
  const float length_squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  const double* sv = mesh_->steering.data() + v * width_;
  const double* sp = mesh_->steering.data() + partner * width_;
  const float w = qv[kQuadricW] + qp[kQuadricW];
  float cost = 0;
  if (!can_move(partner)) {
    for (std::size_t k = 0; k < width_; ++k) {
      differences_[k] = static_cast<float>(sp[k] - sv[k]) * field_scale_[k];
    }
    std::fill(sum_.begin(), sum_.end(), 0.0F);
    add_shifted(qv, d, differences_.data(), width_, sum_.data());
    cost = sum_[kQuadricC] + qp[kQuadricC];
  } else {
    for (std::size_t k = 0; k < width_; ++k) {
      differences_[k] = static_cast<float>(sv[k] - sp[k]) * field_scale_[k];
    }
    std::copy_n(qv, row_, sum_.begin());
    add_shifted(qp, {-d[0], -d[1], -d[2]}, differences_.data(), width_, sum_.data());
    const Reduced r = reduce(sum_.data(), width_);
    const Offset home{0.5F * d[0], 0.5F * d[1], 0.5F * d[2]};
    cost = value_at(r, best_position(r, home, kPull, kReach * std::sqrt(length_squared)));
  }
  const float length_cost = (width_ == 0 ? 1.0F : kLengthCost) * length_squared;
  return (w > 0 ? std::max(cost, 0.0F) / w : 0.0F) + length_cost;
}

// Position and values of the vertex that v and its partner become; sum_ is then their quadric about
// v, or about the partner if that is fixed.
template <class Real>
void FuseRound<Real>::place(VertexId v, VertexId partner) {
  fixed_ = !can_move(partner);
  if (fixed_) {
    position_ = mesh_->positions[partner];
    return;
  }
  const Offset d = offset(v, partner);
  const double* sv = mesh_->steering.data() + v * width_;
  const double* sp = mesh_->steering.data() + partner * width_;
  for (std::size_t k = 0; k < width_; ++k) {
    differences_[k] = static_cast<float>(sv[k] - sp[k]) * field_scale_[k];
  }
  std::copy_n(quadric(v), row_, sum_.begin());
  add_shifted(quadric(partner), {-d[0], -d[1], -d[2]}, differences_.data(), width_, sum_.data());
  const Offset home{0.5F * d[0], 0.5F * d[1], 0.5F * d[2]};
  const float length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const Offset u = best_position(reduce(sum_.data(), width_), home, kPull, kReach * length);
  const Vec3<Real>& p = mesh_->positions[v];
  const double back = 1 / limits_->unit;
  position_ = {static_cast<Real>(p.x + u[0] * back), static_cast<Real>(p.y + u[1] * back),
               static_cast<Real>(p.z + u[2] * back)};
}

template <class Real>
bool FuseRound<Real>::fuse(VertexId v, VertexId partner) {
  if (!plan(v, partner)) return false;
  if (removed_ + deleted_.size() > limits_->quota) {
    reject_ = Reject::kQuota;
    return false;
  }
  const VertexId kept = fixed_ ? partner : std::min(v, partner);
  if (!fixed_ && interpolates_) note_fusion(kept);
  apply(v, partner, kept);
  return true;
}

template <class Real>
bool FuseRound<Real>::plan(VertexId v, VertexId partner) {
  place(v, partner);
  return collect_cavity(v, partner);
}

template <class Real>
bool FuseRound<Real>::collect_cavity(VertexId v, VertexId partner) {
  affected_.clear();
  deleted_.clear();
  worst_ = -1;
  if (!collect_ball(v, partner, true)) return false;
  if (!fixed_ && !collect_ball(partner, v, false)) return false;
  if (!(limits_->min_quality > 0)) return true;
  for (const std::uint32_t entry : affected_) {
    if (!shape_allows(entry)) return false;
  }
  return true;
}

// False at the first affected tetrahedron that would flip.
template <class Real>
bool FuseRound<Real>::collect_ball(VertexId moved, VertexId other, bool note_deleted) {
  const auto& position = mesh_->positions;
  for (const std::uint32_t entry : ball(moved)) {
    const Tet& tet = mesh_->tets[entry >> 2];
    const bool shared = (tet[0] == other) | (tet[1] == other) | (tet[2] == other) |
                        (tet[3] == other);
    if (shared) {
      if (note_deleted) deleted_.push_back(entry >> 2);
      continue;
    }
    const auto& order = kCornerFirst[entry & 3u];
    if (flips(position_, position[tet[order[1]]], position[tet[order[2]]],
              position[tet[order[3]]])) {
      reject_ = Reject::kFlip;
      return false;
    }
    affected_.push_back(entry);
  }
  return true;
}

template <class Real>
bool FuseRound<Real>::shape_allows(std::uint32_t entry) {
  const double floor = limits_->min_quality * limits_->min_quality * limits_->min_quality;
  auto p = corners(mesh_->positions, mesh_->tets[entry >> 2]);
  p[entry & 3u] = position_;
  const double det = determinant(p[0], p[1], p[2], p[3]).value;
  const double ratio = cubed_mean_ratio(p, det, limits_->unit);
  if (ratio >= floor) return true;
  if (worst_ < 0) worst_ = worst_of_cavity();
  if (ratio >= worst_) return true;
  reject_ = Reject::kQuality;
  return false;
}

template <class Real>
double FuseRound<Real>::worst_of_cavity() {
  double worst = 1;
  const auto look = [&](TetId t) {
    const auto p = corners(mesh_->positions, mesh_->tets[t]);
    const double det = determinant(p[0], p[1], p[2], p[3]).value;
    worst = std::min(worst, cubed_mean_ratio(p, det, limits_->unit));
  };
  for (const std::uint32_t entry : affected_) look(entry >> 2);
  for (const TetId t : deleted_) look(t);
  return worst;
}

// The tetrahedron of the cavity that has the new position, for the arrays that are carried.
template <class Real>
void FuseRound<Real>::note_fusion(VertexId kept) {
  Interpolation best;
  best.to = kept;
  double deepest = -std::numeric_limits<double>::infinity();
  const auto look = [&](TetId t) {
    const Tet& tet = mesh_->tets[t];
    const auto p = corners(mesh_->positions, tet);
    std::array<double, 4> weights{};
    double sum = 0, least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 4; ++c) {
      auto q = p;
      q[c] = position_;
      weights[c] = determinant(q[0], q[1], q[2], q[3]).value;
      sum += weights[c];
    }
    if (!(sum > 0)) return false;
    for (double& w : weights) {
      w /= sum;
      least = std::min(least, w);
    }
    if (least > deepest) {
      deepest = least;
      best.from = tet;
      best.weights = weights;
    }
    return least >= 0;
  };
  const auto find = [&] {
    for (const TetId t : deleted_) {
      if (look(t)) return;
    }
    for (const std::uint32_t entry : affected_) {
      if (look(entry >> 2)) return;
    }
  };
  find();
  interpolations_.push_back(best);
}

template <class Real>
void FuseRound<Real>::apply(VertexId v, VertexId partner, VertexId kept) {
  ++now_;
  WorkMesh<Real>& mesh = *mesh_;
  const VertexId gone = kept == v ? partner : v;
  // Quadric and values.
  double* sk = mesh.steering.data() + kept * width_;
  float* qk = mesh.quadrics.data() + kept * row_;
  if (fixed_) {
    const Offset d = offset(v, partner);
    for (std::size_t k = 0; k < width_; ++k) {
      differences_[k] =
          static_cast<float>(sk[k] - mesh.steering[v * width_ + k]) * field_scale_[k];
    }
    add_shifted(quadric(v), d, differences_.data(), width_, qk);
  } else {
    const Vec3<Real>& p = mesh.positions[v];
    const double unit = limits_->unit;
    const Offset u{static_cast<float>((double{position_.x} - p.x) * unit),
                   static_cast<float>((double{position_.y} - p.y) * unit),
                   static_cast<float>((double{position_.z} - p.z) * unit)};
    for (std::size_t k = 0; k < width_; ++k) {
      differences_[k] = best_value(sum_.data(), k, u);
      values_[k] = mesh.steering[v * width_ + k] + double{differences_[k]} / field_scale_[k];
    }
    std::copy(values_.begin(), values_.end(), sk);
    std::fill_n(qk, row_, 0.0F);
    add_shifted(sum_.data(), u, differences_.data(), width_, qk);
    mesh.positions[kept] = position_;
  }
  for (const TetId t : deleted_) {
    Tet& tet = mesh.tets[t];
    for (const VertexId c : tet) {
      --mesh.incidence[c];
      moved_[c] = now_;
    }
    tet[0] = kNoVertex;
  }
  for (const std::uint32_t entry : affected_) {
    Tet& tet = mesh.tets[entry >> 2];
    tet[entry & 3u] = kept;
    for (const VertexId c : tet) moved_[c] = now_;
  }
  removed_ += deleted_.size();
  ++fused_;
  mesh.incidence[gone] = 0;
  balls_[gone].count = 0;
  give_ball(kept, fixed_);
  changed_[kept] = now_;
  changed_[gone] = now_;
  fused_in_[kept] = pass_;
}

// The affected tetrahedra become the ball of the vertex that is kept, or join it.
template <class Real>
void FuseRound<Real>::give_ball(VertexId kept, bool fixed) {
  if (fixed) {
    mesh_->incidence[kept] += static_cast<std::uint32_t>(affected_.size());
    for (const std::uint32_t entry : affected_) (void)entry;
  } else {
    mesh_->incidence[kept] = static_cast<std::uint32_t>(affected_.size());
    balls_[kept].count = 0;
  }
  // Count what is alive of it.
  Ball& b = balls_[kept];
  std::uint32_t live = 0;
  for (std::uint32_t i = 0; i < b.count; ++i) {
    const std::uint32_t entry = entries_[b.begin + i];
    if (!is_deleted(mesh_->tets[entry >> 2])) entries_[b.begin + live++] = entry;
  }
  const auto count = live + static_cast<std::uint32_t>(affected_.size());
  if (count > b.room) {
    const auto begin = static_cast<std::uint32_t>(entries_.size());
    const std::uint32_t room = fixed ? 2 * count : count;
    entries_.resize(entries_.size() + room);
    std::copy_n(entries_.begin() + b.begin, live, entries_.begin() + begin);
    b.begin = begin;
    b.room = room;
  }
  std::copy(affected_.begin(), affected_.end(), entries_.begin() + b.begin + live);
  b.count = count;
}

// An array that steers has the values that the quadrics gave.
template <class Real>
void FuseRound<Real>::write_steering_columns() {
  for (const SteeringField& f : fields_) {
    if (f.column == kNoColumn) continue;
    Column& column = mesh_->point_columns[f.column];
    visit_type(column.type, [&](auto zero) {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>) {
        T* values = reinterpret_cast<T*>(column.rows.data());
        for (std::size_t v = 0; v < balls_.size(); ++v) {
          if (changed_[v] <= 1 || kind_[v] != kFree) continue;
          for (std::uint32_t k = 0; k < f.count; ++k) {
            values[v * f.count + k] = static_cast<T>(
                std::ldexp(mesh_->steering[v * width_ + f.first + k], -f.exponent));
          }
        }
      }
    });
  }
}

template <class Real>
void FuseRound<Real>::compact() {
  WorkMesh<Real>& mesh = *mesh_;
  if (fused_ == 0) return;
  if (interpolates_) {
    for (Column& column : mesh.point_columns) interpolate_point_column(interpolations_, &column);
  }
  write_steering_columns();
  std::size_t tets = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (is_deleted(mesh.tets[t])) continue;
    mesh.tets[tets] = mesh.tets[t];
    for (Column& column : mesh.cell_columns) column.move_row(t, tets);
    ++tets;
  }
  mesh.resize_tets(tets);
  const Vector<VertexId> new_ids = drop_unused_vertices(&mesh);
  for (Tet& t : mesh.tets) {
    for (VertexId& v : t) v = new_ids[v];
  }
}

template void begin_quadrics(std::span<const SteeringField>, double, WorkMesh<float>*);
template void begin_quadrics(std::span<const SteeringField>, double, WorkMesh<double>*);
template class FuseRound<float>;
template class FuseRound<double>;

}  // namespace tetfusion
