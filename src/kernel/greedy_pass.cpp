#include "kernel/greedy_pass.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <limits>

namespace tetfusion {

namespace {

// GreedyPass::state_, as bits.
constexpr std::uint8_t kFusedNow = 1 << 0;  // the vertex a prey of this pass became
constexpr std::uint8_t kTouched = 1 << 1;   // this pass has changed the vertex's ball
constexpr std::uint8_t kStateLocked = 1 << 2;
constexpr std::uint8_t kStateBoundary = 1 << 3;
constexpr std::uint8_t kStateInterface = 1 << 4;

// Does a tetrahedron name one of three vertices? On x86-64 one comparison a vertex for all four
// corners: the question is asked of every tetrahedron of every ball.
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

// The barycenter as it will be written.
template <class Real>
Vec3<Real> barycenter(const std::array<Vec3<Real>, 4>& p) {
  const auto mean = [](double a, double b, double c, double d) {
    return static_cast<Real>(mean_of_four(a, b, c, d));
  };
  return {mean(p[0].x, p[1].x, p[2].x, p[3].x), mean(p[0].y, p[1].y, p[2].y, p[3].y),
          mean(p[0].z, p[1].z, p[2].z, p[3].z)};
}

template <class Real>
double distance_squared(const Vec3<Real>& a, const Vec3<Real>& b) {
  const double x = double{a.x} - b.x, y = double{a.y} - b.y, z = double{a.z} - b.z;
  return x * x + y * y + z * z;
}

std::uint8_t first_state(std::uint8_t marks, BoundaryRule rule) {
  const int boundary = rule == BoundaryRule::kTets ? kOnBoundary | kNearBoundary : kOnBoundary;
  return static_cast<std::uint8_t>(((marks & boundary) != 0 ? kStateBoundary : 0) |
                                   ((marks & kLocked) != 0 ? kStateLocked : 0) |
                                   ((marks & kOnInterface) != 0 ? kStateInterface : 0));
}

// How much of the quota may be gone when tetrahedron t has been dealt with.
std::uint64_t allowance(const PassLimits& limits, std::uint64_t t, std::uint64_t tets) {
  if (limits.quota >= tets || !limits.spread) return limits.quota;
  return limits.quota * (t + 1) / tets;
}

}  // namespace

template <class Real>
PassStatistics GreedyPass<Real>::run(const PassLimits& limits,
                                     std::span<const SteeringField> fields, WorkMesh<Real>* mesh,
                                     FusionLog* log) {
  limits_ = &limits;
  fields_ = fields;
  mesh_ = mesh;
  begin();
  notes_.begin(mesh, log);

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
  if (!notes_.are_wanted()) {
    for (Column& column : mesh->point_columns) carry_point_column(fusions_, &column);
  }
  compact();
  statistics.tets_after = mesh->tets.size();
  return statistics;
}

template <class Real>
void GreedyPass<Real>::begin() {
  const std::size_t vertices = mesh_->vertex_count();
  prepared_ = false;
  fusions_.clear();
  state_.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    state_[v] = first_state(mesh_->marks[v], limits_->boundary_rule);
  }
  mean_.resize(mesh_->steering_width);
}

// What looking round a prey needs, made when the first one is looked round: in the last passes many
// a chunk has none.
template <class Real>
void GreedyPass<Real>::prepare() {
  prepared_ = true;
  build_vertex_tets(mesh_->vertex_count(), mesh_->tets, &balls_);
  if (checks_stretch()) {
    start_positions_ = mesh_->positions;
    start_tets_ = mesh_->tets;
  }
}

template <class Real>
bool GreedyPass<Real>::checks_stretch() const {
  return PaperLimits::is_on(limits_->paper.stretch_factor);
}

template <class Real>
typename GreedyPass<Real>::FirstLook GreedyPass<Real>::look_at(TetId t, Reject* reason) const {
  const Tet& tet = mesh_->tets[t];
  if (is_deleted(tet)) return FirstLook::kLabelled;
  const int any = state_[tet[0]] | state_[tet[1]] | state_[tet[2]] | state_[tet[3]];
  if ((any & kFusedNow) != 0) return FirstLook::kLabelled;
  if ((any & kStateBoundary) != 0) {
    *reason = Reject::kBoundary;
    return FirstLook::kRejected;
  }
  if ((any & kStateLocked) != 0) {
    *reason = Reject::kLocked;
    return FirstLook::kRejected;
  }
  if ((any & kStateInterface) != 0) {
    *reason = Reject::kInterface;
    return FirstLook::kRejected;
  }
  return FirstLook::kCandidate;
}

// Would t be rejected as a flip again? It would while no ball of its vertices has changed since.
template <class Real>
bool GreedyPass<Real>::known_to_flip(TetId t) const {
  const std::uint16_t flipped = mesh_->remembered[t];
  if (flipped == 0) return false;
  const Tet& tet = mesh_->tets[t];
  const auto unchanged = [&](VertexId v) {
    return (state_[v] & kTouched) == 0 && mesh_->changed[v] < flipped;
  };
  return unchanged(tet[0]) && unchanged(tet[1]) && unchanged(tet[2]) && unchanged(tet[3]);
}

template <class Real>
bool GreedyPass<Real>::plan(TetId t, Reject* reason) {
  if (known_to_flip(t)) {
    *reason = Reject::kFlip;
    return false;
  }
  const Tet prey = mesh_->tets[t];
  const std::size_t width = mesh_->steering_width;
  std::array<const double*, 4> values{};
  for (std::size_t i = 0; i < 4; ++i) values[i] = mesh_->steering.data() + prey[i] * width;
  for (std::size_t k = 0; k < width; ++k) {
    mean_[k] = mean_of_four(values[0][k], values[1][k], values[2][k], values[3][k]);
  }
  if (deviates(fields_, limits_->paper.scalar_tolerance, values, mean_.data())) {
    *reason = Reject::kScalar;
    return false;
  }

  if (!prepared_) prepare();
  position_ = barycenter(corners(mesh_->positions, prey));
  if (!collect_cavity(prey)) {
    mesh_->remembered[t] = limits_->number;
    *reason = Reject::kFlip;
    return false;
  }
  if (swallows_locked(prey)) {
    *reason = Reject::kLocked;
    return false;
  }
  return shape_allows(reason);
}

// Sorts the tetrahedra round one vertex of the prey into affected and deleted ones, and stops with
// false at the first affected one that would flip. Nearly all time goes into this loop, so it
// writes to memory set aside before.
template <class Real>
bool GreedyPass<Real>::walk_ball(const Tet& prey, std::size_t corner) {
  const auto& position = mesh_->positions;
  const auto& others = kCornerFirst[corner];
  const NamesAny names_another(prey[others[1]], prey[others[2]], prey[others[3]]);
  const std::span<std::uint32_t> ball = balls_.of(prey[corner]);
  for (std::size_t i = 0; i < ball.size(); ++i) {
    const std::uint32_t entry = ball[i];
    const Tet& tet = mesh_->tets[entry >> 2];
    if (is_deleted(tet)) continue;
    if (names_another(tet)) {
      shared_[shared_count_++] = entry;
      continue;
    }
    const auto& order = kCornerFirst[entry & 3u];
    if (flips(position_, position[tet[order[1]]], position[tet[order[2]]],
              position[tet[order[3]]])) {
      std::swap(ball[0], ball[i]);
      return false;
    }
    affected_[affected_count_++] = entry;
  }
  return true;
}

// Does the tetrahedron that flipped last of all round a vertex?
template <class Real>
bool GreedyPass<Real>::first_flips(const Tet& prey, VertexId v) const {
  const auto& position = mesh_->positions;
  const std::uint32_t entry = balls_.of(v).front();
  const Tet& tet = mesh_->tets[entry >> 2];
  const auto& order = kCornerFirst[entry & 3u];
  const auto names = [&](VertexId u) {
    return (tet[order[1]] == u) | (tet[order[2]] == u) | (tet[order[3]] == u);
  };
  if (is_deleted(tet) || names(prey[0]) || names(prey[1]) || names(prey[2]) || names(prey[3]))
    return false;
  return flips(position_, position[tet[order[1]]], position[tet[order[2]]],
               position[tet[order[3]]]);
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
  for (const VertexId v : prey) {
    if (first_flips(prey, v)) return false;
  }
  for (std::size_t corner = 0; corner < 4; ++corner) {
    if (!walk_ball(prey, corner)) return false;
  }
  for (std::size_t i = 0; i < affected_count_; ++i) {
    const std::uint32_t entry = affected_[i];
    if (flips_as_written(position_, entry & 3u, mesh_->tets[entry >> 2], mesh_->positions)) {
      return false;
    }
  }
  // A deleted tetrahedron was met at each of its prey vertices; it counts at the first of its
  // corners.
  deleted_.clear();
  for (std::size_t i = 0; i < shared_count_; ++i) {
    const Tet& tet = mesh_->tets[shared_[i] >> 2];
    const auto first = std::find_first_of(tet.begin(), tet.end(), prey.begin(), prey.end());
    if (first - tet.begin() == (shared_[i] & 3u)) deleted_.push_back(shared_[i] >> 2);
  }
  return true;
}

// A vertex all of whose tetrahedra are deleted vanishes with them. That must not happen to a locked
// one (a carried cell may need it). Boundary vertices cannot vanish: their boundary triangles stay.
template <class Real>
bool GreedyPass<Real>::swallows_locked(const Tet& prey) const {
  for (const TetId t : deleted_) {
    for (const VertexId v : mesh_->tets[t]) {
      if ((state_[v] & kStateLocked) == 0) continue;
      const auto touches = [&](std::uint32_t entry) {
        return has_corner(mesh_->tets[entry >> 2], v);
      };
      if (!has_corner(prey, v) && std::none_of(affected().begin(), affected().end(), touches))
        return true;
    }
  }
  return false;
}

template <class Real>
bool GreedyPass<Real>::shape_allows(Reject* reason) const {
  const auto refusal = judge_shapes(limits_->paper, *mesh_, affected(), position_,
                                    [&](std::uint32_t entry, const auto& now, const auto& after) {
                                      return stretches_too_far(entry, now, after);
                                    });
  if (refusal) *reason = *refusal;
  return !refusal;
}

// S_N is against the last macroLoD. A tetrahedron that this pass has affected before has other
// corners now than it had there, and its base triangle moves under the vertex that was fused then,
// so that one is looked at again.
template <class Real>
bool GreedyPass<Real>::stretches_too_far(std::uint32_t entry, const std::array<Vec3<Real>, 4>& now,
                                         const std::array<Vec3<Real>, 4>& after) const {
  const double factor = limits_->paper.stretch_factor;
  const auto corner = static_cast<int>(entry & 3u);
  const Tet& tet = mesh_->tets[entry >> 2];
  const int any = state_[tet[0]] | state_[tet[1]] | state_[tet[2]] | state_[tet[3]];
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
  note_fusion(prey, kept);
  if (notes_.are_wanted()) note(fusions_.back());
  for (const std::uint32_t entry : affected()) {
    Tet& tet = mesh_->tets[entry >> 2];
    tet[entry & 3u] = kept;
    for (const VertexId v : tet) state_[v] |= kTouched;
  }
  for (const TetId t : deleted_) {
    for (const VertexId v : mesh_->tets[t]) {
      state_[v] |= kTouched;
      --mesh_->incidence[v];
    }
    mark_deleted(&mesh_->tets[t]);
  }
  for (const VertexId v : prey) mesh_->incidence[v] = 0;
  mesh_->incidence[kept] = static_cast<std::uint32_t>(affected().size());
  state_[kept] |= kFusedNow;
  mesh_->positions[kept] = position_;
  mesh_->marks[kept] |= kMoved;
  std::copy(mean_.begin(), mean_.end(), mesh_->steering.begin() + kept * mean_.size());
  if (!notes_.are_wanted()) return;
  // Whoever notes rows wants them as they are now.
  const std::span<const Fusion> last(&fusions_.back(), 1);
  for (Column& column : mesh_->point_columns) carry_point_column(last, &column);
  notes_.after(0);
}

template <class Real>
void GreedyPass<Real>::note(const Fusion& fusion) {
  const auto& prey = fusion.vertices;
  for (const std::uint32_t entry : affected()) {
    const VertexId v = mesh_->tets[entry >> 2][entry & 3u];
    const auto whose = std::find(prey.begin(), prey.end(), v) - prey.begin();
    notes_.star().push_back(
        {entry >> 2, static_cast<std::uint8_t>(entry & 3u), static_cast<std::uint8_t>(whose)});
  }
  notes_.before(prey[0], std::span(prey).subspan(1), deleted_);
}

template <class Real>
void GreedyPass<Real>::note_fusion(const Tet& prey, VertexId kept) {
  Fusion fusion{prey, 0};
  std::swap(fusion.vertices[0], *std::find(fusion.vertices.begin(), fusion.vertices.end(), kept));
  double least = std::numeric_limits<double>::infinity();
  VertexId least_id = kNoVertex;
  for (std::uint8_t i = 0; i < 4; ++i) {
    const VertexId v = fusion.vertices[i];
    const double distance = distance_squared(mesh_->positions[v], position_);
    if (distance < least || (distance == least && mesh_->point_ids[v] < least_id)) {
      least = distance;
      least_id = mesh_->point_ids[v];
      fusion.nearest = i;
    }
  }
  fusions_.push_back(fusion);
}

template <class Real>
void GreedyPass<Real>::compact() {
  WorkMesh<Real>& mesh = *mesh_;
  if (fusions_.empty()) return;
  for (std::size_t v = 0; v < state_.size(); ++v) {
    if ((state_[v] & kTouched) != 0) mesh.changed[v] = limits_->number;
  }
  drop_deleted(&mesh);
}

template class GreedyPass<float>;
template class GreedyPass<double>;

}  // namespace tetfusion
