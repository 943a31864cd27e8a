#include "kernel/fuse/fuse_round.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernel/quadrics/vertex_quadrics.h"

namespace tetfusion {

namespace {

// Bins: a block has so many before the next one's turn comes, and then failures are asked again.
constexpr std::size_t kOctave = 8;
// Whoever has its turn, and has been refused, tries what comes so many bins later, too, as its ball
// is at hand.
constexpr std::size_t kAhead = 1;
// The watcher is told of these in one; surfaces take a millisecond each where they look at all of
// the others.
constexpr std::uint32_t kVisitsUntold = 64;
// A round is over when all have been asked, and less than this share of the tetrahedra went.
constexpr double kIdleShare = 0.02;

// Are there point columns that get neither steering values nor, with their integrals, the rows that
// keep these?
template <class Real>
bool has_columns_to_interpolate(const FuseLimits& limits, std::span<const SteeringField> fields,
                                const WorkMesh<Real>& mesh) {
  const auto steering_columns =
      std::ranges::count_if(fields, [&](const SteeringField& f) { return is_column(f, mesh); });
  return !limits.keep_integrals &&
         static_cast<std::size_t>(steering_columns) < mesh.point_columns.size();
}

}  // namespace

template <class Real>
void FuseRound<Real>::begin(const FuseLimits& limits, std::span<const SteeringField> fields,
                            WorkMesh<Real>* mesh) {
  limits_ = &limits;
  threshold_ = static_cast<float>(limits.threshold);
  fields_ = fields;
  mesh_ = mesh;
  interpolates_ = has_columns_to_interpolate(limits, fields, *mesh);
  vertices_.begin(limits, mesh);
  edge_costs_.begin(mesh, fields, limits.unit, limits.sheet_weight);
  candidates_.begin(limits, mesh, &vertices_, &edge_costs_);
  planner_.begin(limits, fields, mesh, &vertices_, &edge_costs_);
  queue_.reset(mesh->vertex_count());
  failures_.resize(queue_.blocks());
  for (Vector<VertexId>& of_block : failures_) of_block.clear();
  removed_ = 0;
  fused_ = 0;
  deviated_ = 0;
  refitted_.clear();
  told_ = 0;
  visits_ = 0;
  interpolations_.clear();
}

// Weights multiply what it costs, too: so much less is added.
template <class Real>
void FuseRound<Real>::add_gradient_variances() {
  const auto variance = static_cast<float>(limits_->gradient_variance);
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    add_gradient_variance(variance / vertices_.cost_factor(v, v),
                          mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width);
  }
}

template <class Real>
FuseStatistics FuseRound<Real>::run(const FuseLimits& limits, std::span<const SteeringField> fields,
                                    WorkMesh<Real>* mesh, FusionLog* log) {
  begin(limits, fields, mesh);
  tell_watcher();
  if (limits.gradient_variance > 0) add_gradient_variances();
  notes_.begin(mesh, log);
  work();
  refit();
  planner_.finish();
  FuseStatistics statistics;
  finish(&statistics);
  compact();
  return statistics;
}

template <class Real>
FuseStatistics FuseRound<Real>::look(const FuseLimits& limits,
                                     std::span<const SteeringField> fields, WorkMesh<Real>* mesh) {
  begin(limits, fields, mesh);
  FuseStatistics statistics;
  finish(&statistics);
  return statistics;
}

// Counts what is left, and notes what is known of it for the next round.
template <class Real>
void FuseRound<Real>::finish(FuseStatistics* statistics) {
  PassStatistics& pass = statistics->pass;
  pass.tets_before = mesh_->tets.size();
  pass.tets_after = pass.tets_before - removed_;
  pass.fused = fused_;
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    if (mesh_->incidence[v] == 0) continue;
    float least = 0, failed = 0;
    const Reject reason = look_back(v, &least, &failed);
    if (!is_counted_elsewhere(mesh_->marks[v])) ++pass.rejected[static_cast<std::size_t>(reason)];
    known_cost(mesh_, v) = failed > 0 ? -failed : least;
    if (least > 0) ++statistics->costs[cost_bin(least)];
    if (limits_->facing_after != nullptr) {
      vertices_.sheets().note_facing(v, limits_->marks_are_known, limits_->facing_after);
    }
    if (mesh_->has_deviations) {
      statistics->deviation = std::max(statistics->deviation, mesh_->deviations[v]);
    }
  }
}

// Why the vertex has not fused; `least` gets what its cheapest fusion costs that has not failed,
// `failed` that of the cheapest one that has, if they are known.
template <class Real>
Reject FuseRound<Real>::look_back(VertexId v, float* least, float* failed) {
  if (!vertices_.may_move(v)) {
    const std::uint8_t marks = mesh_->marks[v];
    const bool on_boundary = (marks & kOnBoundary) != 0;
    const bool stays_anyway = on_boundary && !limits_->sheets_move();
    if ((marks & kOnInterface) != 0 && !stays_anyway) return Reject::kInterface;
    const bool is_corner = on_boundary && (marks & kLocked) == 0;
    return stays_anyway || is_corner ? Reject::kBoundary : Reject::kLocked;
  }
  const float known = known_cost(mesh_, v);
  if (candidates_.are_known(v) || !(known > 0)) {
    if (!candidates_.are_known(v)) candidates_.judge(v);
    const bool has_failed = vertices_[v].has_failed();
    candidates_.for_each(v, [&](const FuseCandidate& c) {
      float* const cost = c.cost <= threshold_ && has_failed ? failed : least;
      if (*cost == 0) *cost = c.cost;
    });
  } else {
    *least = known;
  }
  if (*failed > 0) return static_cast<Reject>(vertices_[v].reason);
  return *least > 0 && *least <= threshold_ && quota_is_met() ? Reject::kQuota : Reject::kError;
}

// Vertices take turns, those with the cheapest candidates first; but a block has an octave of turns
// before the next one. Where a fusion failed, the vertex is asked again when something near it has
// moved.
template <class Real>
void FuseRound<Real>::work() {
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    if (vertices_.may_move(v)) wait(v, std::abs(known_cost(mesh_, v)));
  }
  const std::size_t end = CostQueue::bin_of(threshold_) + 1;
  std::uint64_t removed_before = 0;
  do {
    removed_before = removed_;
    for (std::size_t bin = 0; bin < end; bin += kOctave) {
      for (std::size_t block = 0; block < queue_.blocks(); ++block) {
        ask_again(block, Edges::kOwn);
        work_on(block, bin, std::min(bin + kOctave, end));
        tell_watcher();
      }
    }
    for (std::size_t block = 0; block < queue_.blocks(); ++block) queue_.go_to(block, 0);
    const auto left = static_cast<double>(mesh_->tets.size() - removed_);
    if (static_cast<double>(removed_ - removed_before) < kIdleShare * left) return;
    candidates_.ask_refused_ones();
    planner_.be_thorough();
  } while (!quota_is_met() && begin_again());
}

// Who has failed gets another try, with all edges: those that were the other end's business, too.
template <class Real>
bool FuseRound<Real>::begin_again() {
  bool any = false;
  for (std::size_t block = 0; block < queue_.blocks(); ++block) {
    any = ask_again(block, Edges::kAll) || any;
  }
  return any;
}

// For the vertex's turn, if it comes in this round: a vertex that waits does so until then.
template <class Real>
bool FuseRound<Real>::wait(VertexId v, float cost) {
  if (!(cost <= threshold_)) return false;
  queue_.push(v, cost);
  return true;
}

template <class Real>
void FuseRound<Real>::work_on(std::size_t block, std::size_t begin, std::size_t end) {
  for (bin_ = begin; bin_ < end; ++bin_) {
    queue_.go_to(block, bin_);
    while (!quota_is_met()) {
      const VertexId v = queue_.pop(block);
      if (v == kNoVertex) break;
      prefetch_ahead(queue_.first(block));
      if (mesh_->incidence[v] == 0) continue;
      visit(v);
      if (++visits_ % kVisitsUntold == 0) tell_watcher();
    }
  }
  // Whoever comes when the last octave is over has its turn in the next round (bench/TRIED.md).
  queue_.go_to(block, end);
}

template <class Real>
void FuseRound<Real>::tell_watcher() {
  if (watcher_) watcher_(removed_ - std::exchange(told_, removed_));
}

// For what is known of the vertices whose turn comes next.
template <class Real>
void FuseRound<Real>::prefetch_ahead(VertexId next) const {
  if (next == kNoVertex) return;
  vertices_.balls().prefetch_tets(next, mesh_->tets);
  candidates_.prefetch_partner(next);
  const VertexId second = queue_.after(next);
  if (second == kNoVertex) return;
  vertices_.balls().prefetch_entries(second);
  const VertexId third = queue_.after(second);
  if (third == kNoVertex) return;
  vertices_.balls().prefetch_ball(third);
  __builtin_prefetch(&vertices_[third]);
  candidates_.prefetch_list(third);
  __builtin_prefetch(&mesh_->incidence[third]);
}

// Of a block, where something near has moved since. What had its quadric last has judged its edges
// itself.
template <class Real>
bool FuseRound<Real>::ask_again(std::size_t block, Edges edges) {
  bool any = false;
  Vector<VertexId>& failures = failures_[block];
  std::size_t kept = 0;
  for (const VertexId v : failures) {
    State& state = vertices_[v];
    state.listed = false;
    if (mesh_->incidence[v] == 0 || state.failed < state.changed) continue;
    if (!state.has_failed()) {
      if (edges == Edges::kAll) candidates_.judge(v, edges);
      candidates_.begin_again(v);
      const FuseCandidate* c = candidates_.next(v);
      if (c != nullptr && wait(v, c->cost)) {
        any = true;
        continue;
      }
      state.failed = vertices_.now();
    }
    state.listed = true;
    failures[kept++] = v;
  }
  failures.resize(kept);
  return any;
}

// Tries the vertex's candidates whose turn has come, up to the first that it may fuse with.
template <class Real>
void FuseRound<Real>::visit(VertexId v) {
  if (!candidates_.are_known(v)) candidates_.judge(v);
  while (const FuseCandidate* c = candidates_.next(v)) {
    if (c->cost > threshold_) return;
    if (CostQueue::bin_of(c->cost) > bin_ + kAhead) {
      queue_.push(v, c->cost);
      return;
    }
    if (!try_next(v, *c)) continue;
    const VertexId kept = planner_.kept();
    if (!vertices_.may_move(kept)) return;
    candidates_.judge(kept);
    if (const FuseCandidate* next = candidates_.next(kept)) wait(kept, next->cost);
    return;
  }
}

template <class Real>
bool FuseRound<Real>::try_next(VertexId v, const FuseCandidate& candidate) {
  vertices_.balls().prefetch_entries(candidate.partner);
  const auto refused = planner_.plan(v, candidate.partner, limits_->quota - removed_);
  if (!refused) {
    fuse(candidate.cost);
    return true;
  }
  if (refused->dear > 0) {
    candidates_.raise_cost(v, refused->dear);
    return false;
  }
  candidates_.use_up(v, refused->until_changed);
  note_failure(v, refused->reason);
  return false;
}

// One reason may stand for several candidates. A bound is the one that somebody may want to change.
template <class Real>
void FuseRound<Real>::note_failure(VertexId v, Reject reason) {
  constexpr auto kBound = static_cast<std::uint8_t>(Reject::kDeviation);
  State& state = vertices_[v];
  if (reason == Reject::kDeviation) ++deviated_;
  const bool keeps_reason = state.has_failed() && state.reason == kBound;
  if (!keeps_reason) state.reason = static_cast<std::uint8_t>(reason);
  state.failed = vertices_.now();
  if (!state.listed) failures_[queue_.block_of(v)].push_back(v);
  state.listed = true;
}

template <class Real>
void FuseRound<Real>::fuse(float cost) {
  const auto& [v, partner, fixed, position, affected, deleted] = planner_.joining();
  const VertexId kept = planner_.kept(), gone = kept == v ? partner : v;
  const std::uint32_t now = vertices_.next_event();
  const float error = notes_.are_wanted() ? error_above(cost) : 0;
  if (!fixed && interpolates_) interpolations_.push_back(planner_.interpolation());
  if (notes_.are_wanted()) note(kept, gone);
  planner_.apply();
  if (!fixed) mesh_->marks[kept] |= kMoved;
  vertices_.join_weights(v, partner, kept);
  merge_quadrics();
  move_tets(kept, gone);
  removed_ += deleted.size();
  ++fused_;
  vertices_[v].changed = now;
  vertices_[partner].changed = now;
  planner_.note_fused();
  if (!notes_.are_wanted()) return;
  carry_rows(kept);
  notes_.after(error);
}

template <class Real>
void FuseRound<Real>::note(VertexId kept, VertexId gone) {
  const auto& [v, partner, fixed, position, affected, deleted] = planner_.joining();
  const auto add = [&](std::uint32_t entry, bool was_gone) {
    notes_.star().push_back({entry >> 2, static_cast<std::uint8_t>(entry & 3u), was_gone});
  };
  for (const std::uint32_t entry : affected)
    add(entry, mesh_->tets[entry >> 2][entry & 3u] == gone);
  if (fixed) {
    for (const std::uint32_t entry : vertices_.ball(kept)) {
      if (!has_corner(mesh_->tets[entry >> 2], gone)) add(entry, false);
    }
  }
  notes_.before(kept, {&gone, 1}, deleted);
}

template <class Real>
float FuseRound<Real>::error_above(float cost) const {
  const double error = planner_.error(cost);
  const auto single = static_cast<float>(error);
  return single < error ? std::nextafter(single, std::numeric_limits<float>::infinity()) : single;
}

// What compact() does for all at once: whoever notes rows wants them as they are now.
template <class Real>
void FuseRound<Real>::carry_rows(VertexId kept) {
  for (Column& column : mesh_->point_columns) interpolate_point_column(interpolations_, &column);
  interpolations_.clear();
  if (vertices_.may_move(kept)) write_steering_columns(fields_, {&kept, 1}, mesh_);
}

// One that stays where it is keeps its values, too.
template <class Real>
void FuseRound<Real>::merge_quadrics() {
  const auto& [v, partner, fixed, position, affected, deleted] = planner_.joining();
  const VertexId kept = planner_.kept();
  const bool on_sheet = vertices_.is_on_sheet(v);
  const std::size_t size = mesh_->quadric_width, width = mesh_->steering_width;
  float* row = mesh_->quadrics.data() + kept * size;
  double* values = mesh_->steering.data() + kept * width;
  if (fixed) {
    edge_costs_.add(v, position, values, row);
    if (on_sheet) edge_costs_.add_sheet(v, position, row);
    return;
  }
  std::fill_n(row, size, 0.0F);
  edge_costs_.add(planner_.merged(), v, position, planner_.values().data(), row);
  if (on_sheet) edge_costs_.add_sheet(planner_.merged(), v, position, row);
  std::copy_n(planner_.values().data(), width, values);
  mesh_->positions[kept] = position;
}

template <class Real>
void FuseRound<Real>::move_tets(VertexId kept, VertexId gone) {
  const auto& [v, partner, fixed, position, affected, deleted] = planner_.joining();
  const std::uint32_t now = vertices_.now();
  WorkMesh<Real>& mesh = *mesh_;
  const bool sheets_move = limits_->sheets_move();
  const auto note_moved = [&](VertexId u) {
    vertices_[u].moved = now;
    if (sheets_move) vertices_.sheets().forget_fan(u);
  };
  for (const TetId t : deleted) {
    for (const VertexId u : mesh.tets[t]) {
      --mesh.incidence[u];
      note_moved(u);
    }
    mark_deleted(&mesh.tets[t]);
  }
  for (const std::uint32_t entry : affected) {
    Tet& tet = mesh.tets[entry >> 2];
    tet[entry & 3u] = kept;
    for (const VertexId u : tet) note_moved(u);
  }
  LiveBalls& balls = vertices_.balls();
  mesh.incidence[gone] = 0;
  balls.clear(gone);
  if (!fixed) {
    mesh.incidence[kept] = 0;
    balls.clear(kept);
  }
  vertices_.ball(kept);  // drops what is gone
  balls.add(kept, affected);
  mesh.incidence[kept] += static_cast<std::uint32_t>(affected.size());
}

// Where bounds have begun to matter, of vertices inside whose balls have changed: smaller errors
// leave more room in the next round. A log has rows as the last fusion left them.
template <class Real>
void FuseRound<Real>::refit() {
  if (deviated_ == 0 || notes_.are_wanted() || !planner_.may_refit()) return;
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    if (mesh_->incidence[v] == 0 || vertices_[v].is_as_it_began() ||
        (mesh_->marks[v] & kMoved) == 0 || vertices_[v].kind != FuseVertices<Real>::kFree) {
      continue;
    }
    if (planner_.refit(v)) take_refitted(v, mesh_->positions[v]);
    const std::optional<Vec3<Real>> position = planner_.refit_position(v);
    if (!position) continue;
    if (interpolates_) interpolations_.push_back(planner_.interpolation());
    take_refitted(v, *position);
    planner_.note_fused();
  }
}

// Its quadric is about its position and its values.
template <class Real>
void FuseRound<Real>::take_refitted(VertexId v, const Vec3<Real>& position) {
  const std::size_t width = mesh_->steering_width;
  quadric_.assign(quadric_size(width), 0);
  edge_costs_.add(v, position, planner_.values().data(), quadric_.data());
  std::ranges::copy(quadric_, mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width);
  std::ranges::copy(planner_.values(), mesh_->steering.data() + std::size_t{v} * width);
  mesh_->positions[v] = position;
  refitted_.push_back(v);
}

template <class Real>
void FuseRound<Real>::compact() {
  WorkMesh<Real>& mesh = *mesh_;
  if (fused_ == 0 && refitted_.empty()) return;
  if (interpolates_) {
    for (Column& column : mesh.point_columns) interpolate_point_column(interpolations_, &column);
  }
  Vector<VertexId> moved = refitted_;
  for (VertexId v = 0; v < vertices_.size(); ++v) {
    if (vertices_[v].has_fused() && vertices_.may_move(v)) moved.push_back(v);
  }
  write_steering_columns(fields_, moved, &mesh);
  drop_deleted(&mesh);
}

template class FuseRound<float>;
template class FuseRound<double>;

}  // namespace tetfusion
