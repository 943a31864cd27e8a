#include "kernel/greedy_pass.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <limits>

namespace tetfusion {

namespace {

// Lower bits of GreedyPass::state_.
constexpr std::uint32_t kFusedNow = 1;      // the vertex a prey of this pass became
constexpr std::uint32_t kDead = 2;          // a prey's other three vertices
constexpr std::uint32_t kStateLocked = 4;
constexpr std::uint32_t kStateBoundary = 8;
constexpr std::uint32_t kStateBits = 15;
constexpr int kTimeShift = 4;
// Half of what 28 bits can count: a pass makes fewer fusions than that.
constexpr std::uint32_t kLatestStart = std::uint32_t{1} << 27;

bool is_deleted(const Tet& tet) { return tet[0] == kNoVertex; }

// Does a tetrahedron name one of three vertices? On x86-64 one comparison a vertex for all four corners: the question
// is asked of every tetrahedron of every ball.
class NamesAny {
 public:
#ifdef __SSE2__
  NamesAny(VertexId p, VertexId q, VertexId r) : p_(spread(p)), q_(spread(q)), r_(spread(r)) {}
  bool operator()(const Tet& tet) const {
    const __m128i corners = _mm_loadu_si128(reinterpret_cast<const __m128i*>(tet.data()));
    const __m128i equal =
        _mm_or_si128(_mm_or_si128(_mm_cmpeq_epi32(corners, p_), _mm_cmpeq_epi32(corners, q_)),
                     _mm_cmpeq_epi32(corners, r_));
    return _mm_movemask_epi8(equal) != 0;
  }

 private:
  static __m128i spread(VertexId v) { return _mm_set1_epi32(static_cast<int>(v)); }
  __m128i p_, q_, r_;
#else
  NamesAny(VertexId p, VertexId q, VertexId r) : p_(p), q_(q), r_(r) {}
  bool operator()(const Tet& tet) const {
    bool any = false;
    for (const VertexId v : tet) any |= (v == p_) | (v == q_) | (v == r_);
    return any;
  }

 private:
  VertexId p_, q_, r_;
#endif
};

template <class Real>
std::array<Vec3<Real>, 4> corners(const Vector<Vec3<Real>>& positions, const Tet& t) {
  return {positions[t[0]], positions[t[1]], positions[t[2]], positions[t[3]]};
}

// The barycenter as it will be written.
template <class Real>
Vec3<Real> barycenter(const std::array<Vec3<Real>, 4>& p) {
  const auto mean = [](double a, double b, double c, double d) {
    return static_cast<Real>(0.25 * ((a + b) + (c + d)));
  };
  return {mean(p[0].x, p[1].x, p[2].x, p[3].x), mean(p[0].y, p[1].y, p[2].y, p[3].y),
          mean(p[0].z, p[1].z, p[2].z, p[3].z)};
}

template <class Real>
double distance_squared(const Vec3<Real>& a, const Vec3<Real>& b) {
  const double x = double{a.x} - b.x, y = double{a.y} - b.y, z = double{a.z} - b.z;
  return x * x + y * y + z * z;
}

std::uint32_t first_state(std::uint8_t marks, BoundaryRule rule) {
  const int boundary = rule == BoundaryRule::kTets ? kOnBoundary | kNearBoundary : kOnBoundary;
  return ((marks & boundary) != 0 ? kStateBoundary : 0u) | ((marks & kLocked) != 0 ? kStateLocked : 0u);
}

// How much of the quota may be gone when tetrahedron t has been dealt with.
std::uint64_t allowance(const PassLimits& limits, std::uint64_t t, std::uint64_t tets) {
  if (limits.quota >= tets || !limits.spread) return limits.quota;
  return limits.quota * (t + 1) / tets;
}

}  // namespace

template <class Real>
PassStatistics GreedyPass<Real>::run(const PassLimits& limits, std::span<const SteeringField> fields,
                                     WorkMesh<Real>* mesh, FuseLog* log) {
  limits_ = &limits;
  fields_ = fields;
  mesh_ = mesh;
  log_ = log;
  begin();

  PassStatistics statistics;
  const auto tets = static_cast<TetId>(mesh->tets.size());
  statistics.tets_before = tets;
  std::uint64_t removed = 0;
  for (TetId t = 0; t < tets; ++t) {
    Reject reason{};
    const FirstLook look = look_at(t, &reason);
    if (look == FirstLook::kLabelled) {
      ++statistics.labelled;
      continue;
    }
    const std::uint64_t allowed = allowance(limits, t, tets);
    if (look == FirstLook::kCandidate && removed >= allowed) {
      reason = Reject::kQuota;
    } else if (look == FirstLook::kCandidate && plan(t, &reason)) {
      if (removed + deleted_.size() <= allowed) {
        const Tet prey = mesh->tets[t];
        removed += deleted_.size();
        apply(prey);
        ++statistics.fused;
        continue;
      }
      reason = Reject::kQuota;
    }
    ++statistics.rejected[static_cast<std::size_t>(reason)];
  }
  compact();
  log->pass_ends.push_back(log->records.size());
  statistics.tets_after = mesh->tets.size();
  return statistics;
}

template <class Real>
void GreedyPass<Real>::begin() {
  const std::size_t vertices = mesh_->vertex_count();
  build_vertex_tets(vertices, mesh_->tets, &balls_);
  // A tetrahedron that once passed the scalar test passes a wider one too: only a narrower tolerance would give
  // a remembered flip another reason.
  const bool remembers = state_.size() == vertices && flip_time_.size() == mesh_->tets.size() &&
                         limits_->scalar_tolerance >= scalar_tolerance_ && time_ <= kLatestStart;
  if (!remembers) {
    state_.assign(vertices, 0);
    flip_time_.assign(mesh_->tets.size(), 0);
    time_ = 1;
  }
  scalar_tolerance_ = limits_->scalar_tolerance;
  for (std::size_t v = 0; v < vertices; ++v) {
    state_[v] = (state_[v] & ~kStateBits) | first_state(mesh_->marks[v], limits_->boundary_rule);
  }
  mean_.resize(mesh_->steering_width);
  start_positions_.clear();
  start_tets_.clear();
  if (limits_->stretch_factor < std::numeric_limits<double>::infinity()) {
    start_positions_ = mesh_->positions;
    start_tets_ = mesh_->tets;
  }
}

template <class Real>
typename GreedyPass<Real>::FirstLook GreedyPass<Real>::look_at(TetId t, Reject* reason) const {
  const Tet& tet = mesh_->tets[t];
  if (is_deleted(tet)) return FirstLook::kLabelled;
  const std::uint32_t a = state_[tet[0]], b = state_[tet[1]], c = state_[tet[2]], d = state_[tet[3]];
  const std::uint32_t any = a | b | c | d;
  if ((any & kFusedNow) != 0) return FirstLook::kLabelled;
  if ((any & kStateBoundary) != 0) {
    *reason = Reject::kBoundary;
    return FirstLook::kRejected;
  }
  if ((any & kStateLocked) != 0) {
    *reason = Reject::kLocked;
    return FirstLook::kRejected;
  }
  return FirstLook::kCandidate;
}

// Would t be rejected as a flip again? It would while no ball of its vertices has changed since.
template <class Real>
bool GreedyPass<Real>::known_to_flip(const Tet& tet, std::uint32_t flip_time) const {
  if (flip_time == 0) return false;
  const std::uint32_t last_change =
      std::max({state_[tet[0]], state_[tet[1]], state_[tet[2]], state_[tet[3]]}) >> kTimeShift;
  return last_change <= flip_time;
}

template <class Real>
bool GreedyPass<Real>::plan(TetId t, Reject* reason) {
  const Tet prey = mesh_->tets[t];
  if (known_to_flip(prey, flip_time_[t])) {
    *reason = Reject::kFlip;
    return false;
  }
  const std::size_t width = mesh_->steering_width;
  std::array<const double*, 4> values{};
  for (std::size_t i = 0; i < 4; ++i) values[i] = mesh_->steering.data() + prey[i] * width;
  for (std::size_t k = 0; k < width; ++k) {
    mean_[k] = 0.25 * ((values[0][k] + values[1][k]) + (values[2][k] + values[3][k]));
  }
  if (deviates(fields_, limits_->scalar_tolerance, values, mean_.data())) {
    *reason = Reject::kScalar;
    return false;
  }

  position_ = barycenter(corners(mesh_->positions, prey));
  if (!collect_cavity(prey)) {
    flip_time_[t] = time_;
    *reason = Reject::kFlip;
    return false;
  }
  if (swallows_locked(prey)) {
    *reason = Reject::kLocked;
    return false;
  }
  return shape_allows(reason);
}

// Sorts the tetrahedra round one vertex of the prey into affected and deleted ones, and stops with false at the first
// affected one that would flip. Nearly all time goes into this loop, so it writes to memory set aside before.
template <class Real>
bool GreedyPass<Real>::walk_ball(const Tet& prey, std::size_t corner) {
  const auto& position = mesh_->positions;
  const auto& others = kCornerFirst[corner];
  const NamesAny names_another(prey[others[1]], prey[others[2]], prey[others[3]]);
  for (const std::uint32_t entry : balls_.of(prey[corner])) {
    const Tet& tet = mesh_->tets[entry >> 2];
    if (is_deleted(tet)) continue;
    if (names_another(tet)) {
      shared_[shared_count_++] = entry;
      continue;
    }
    const auto& order = kCornerFirst[entry & 3u];
    if (flips(position_, position[tet[order[1]]], position[tet[order[2]]], position[tet[order[3]]])) {
      return false;
    }
    affected_[affected_count_++] = entry;
  }
  return true;
}

// Walks the four balls of the prey. False when an affected tetrahedron would flip.
template <class Real>
bool GreedyPass<Real>::collect_cavity(const Tet& prey) {
  std::size_t entries = 0;
  for (const VertexId v : prey) entries += balls_.of(v).size();
  if (affected_.size() < entries) {
    affected_.resize(2 * entries);
    shared_.resize(2 * entries);
  }
  affected_count_ = 0;
  shared_count_ = 0;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    if (!walk_ball(prey, corner)) return false;
  }
  // A deleted tetrahedron was met at each of its prey vertices; it counts at the first of its corners.
  deleted_.clear();
  for (std::size_t i = 0; i < shared_count_; ++i) {
    const Tet& tet = mesh_->tets[shared_[i] >> 2];
    const auto first = std::find_first_of(tet.begin(), tet.end(), prey.begin(), prey.end());
    if (first - tet.begin() == (shared_[i] & 3u)) deleted_.push_back(shared_[i] >> 2);
  }
  return true;
}

// A vertex all of whose tetrahedra are deleted vanishes with them. That must not happen to a locked one (a
// carried cell may need it). Boundary vertices cannot vanish: their boundary triangles stay.
template <class Real>
bool GreedyPass<Real>::swallows_locked(const Tet& prey) const {
  for (const TetId t : deleted_) {
    for (const VertexId v : mesh_->tets[t]) {
      if ((state_[v] & kStateLocked) == 0) continue;
      const auto touches = [&](std::uint32_t entry) {
        const Tet& tet = mesh_->tets[entry >> 2];
        return std::find(tet.begin(), tet.end(), v) != tet.end();
      };
      const bool in_prey = std::find(prey.begin(), prey.end(), v) != prey.end();
      if (!in_prey && std::none_of(affected().begin(), affected().end(), touches)) return true;
    }
  }
  return false;
}

// Stretch and aspect ratio of the affected tetrahedra.
template <class Real>
bool GreedyPass<Real>::shape_allows(Reject* reason) const {
  const bool check_stretch = !start_tets_.empty();
  const bool check_aspect = limits_->aspect_ratio < std::numeric_limits<double>::infinity();
  if (!check_stretch && !check_aspect) return true;
  for (const std::uint32_t entry : affected()) {
    const auto now = corners(mesh_->positions, mesh_->tets[entry >> 2]);
    auto after = now;
    after[entry & 3u] = position_;
    if (check_stretch && stretches_too_far(entry, now, after)) {
      *reason = Reject::kStretch;
      return false;
    }
    if (check_aspect && distorts(now, after, limits_->aspect_ratio)) {
      *reason = Reject::kAspect;
      return false;
    }
  }
  return true;
}

// S_N is against the last macroLoD. A tetrahedron that this pass has affected before has other corners now than it had
// there, and its base triangle moves under the vertex that was fused then, so that one is looked at again.
template <class Real>
bool GreedyPass<Real>::stretches_too_far(std::uint32_t entry, const std::array<Vec3<Real>, 4>& now,
                                         const std::array<Vec3<Real>, 4>& after) const {
  const double factor = limits_->stretch_factor;
  const auto corner = static_cast<int>(entry & 3u);
  const Tet& tet = mesh_->tets[entry >> 2];
  const std::uint32_t any = state_[tet[0]] | state_[tet[1]] | state_[tet[2]] | state_[tet[3]];
  if ((any & kFusedNow) == 0) return stretches(now, after, corner, factor);
  const auto before = corners(start_positions_, start_tets_[entry >> 2]);
  for (int c = 0; c < 4; ++c) {
    const bool moved = c == corner || (state_[tet[static_cast<std::size_t>(c)]] & kFusedNow) != 0;
    if (moved && stretches(before, after, c, factor)) return true;
  }
  return false;
}

template <class Real>
void GreedyPass<Real>::apply(const Tet& prey) {
  const VertexId kept = std::min({prey[0], prey[1], prey[2], prey[3]});
  log_fusion(prey, kept);
  ++time_;
  for (const std::uint32_t entry : affected()) {
    Tet& tet = mesh_->tets[entry >> 2];
    tet[entry & 3u] = kept;
    for (const VertexId v : tet) touch(v);
  }
  for (const TetId t : deleted_) {
    Tet& tet = mesh_->tets[t];
    for (const VertexId v : tet) touch(v);
    tet[0] = kNoVertex;
  }
  for (const VertexId v : prey) state_[v] |= v == kept ? kFusedNow : kDead;
  mesh_->positions[kept] = position_;
  std::copy(mean_.begin(), mean_.end(), mesh_->steering.begin() + kept * mean_.size());
}

template <class Real>
void GreedyPass<Real>::log_fusion(const Tet& prey, VertexId kept) {
  Tet order = prey;
  std::swap(order[0], *std::find(order.begin(), order.end(), kept));
  FuseRecord record{};
  std::uint8_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint8_t i = 0; i < 4; ++i) {
    record.points[i] = mesh_->point_ids[order[i]];
    const double distance = distance_squared(mesh_->positions[order[i]], position_);
    if (distance < least || (distance == least && record.points[i] < record.points[nearest])) {
      least = distance;
      nearest = i;
    }
  }
  log_->records.push_back(record);
  log_->nearest.push_back(nearest);
}

template <class Real>
void GreedyPass<Real>::touch(VertexId v) {
  state_[v] = (time_ << kTimeShift) | (state_[v] & kStateBits);
}

template <class Real>
void GreedyPass<Real>::compact() {
  WorkMesh<Real>& mesh = *mesh_;
  std::size_t tets = 0;
  new_ids_.assign(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (is_deleted(mesh.tets[t])) continue;
    for (const VertexId v : mesh.tets[t]) new_ids_[v] = 1;
    mesh.tets[tets] = mesh.tets[t];
    mesh.tet_ids[tets] = mesh.tet_ids[t];
    flip_time_[tets] = flip_time_[t];
    ++tets;
  }
  mesh.tets.resize(tets);
  mesh.tet_ids.resize(tets);
  flip_time_.resize(tets);

  VertexId vertices = 0;
  const std::size_t width = mesh.steering_width;
  for (std::size_t v = 0; v < new_ids_.size(); ++v) {
    // A locked vertex may belong to carried cells alone.
    if (new_ids_[v] == 0 && (mesh.marks[v] & kLocked) == 0) continue;
    const VertexId to = vertices++;
    new_ids_[v] = to;
    mesh.positions[to] = mesh.positions[v];
    mesh.marks[to] = mesh.marks[v];
    mesh.point_ids[to] = mesh.point_ids[v];
    state_[to] = state_[v];
    std::copy_n(mesh.steering.begin() + v * width, width, mesh.steering.begin() + to * width);
  }
  mesh.positions.resize(vertices);
  mesh.marks.resize(vertices);
  mesh.point_ids.resize(vertices);
  mesh.steering.resize(vertices * width);
  state_.resize(vertices);
  for (Tet& tet : mesh.tets) {
    for (VertexId& v : tet) v = new_ids_[v];
  }
}

template class GreedyPass<float>;
template class GreedyPass<double>;

}  // namespace tetfusion
