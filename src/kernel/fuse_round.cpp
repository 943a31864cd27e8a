#include "kernel/fuse_round.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// Where the best position is not allowed, others may cost so much more.
constexpr float kSlack = 1.3F;
// cheapest_step(): from 0.003 to 0.3 all does about the same.
constexpr float kPushPull = 0.01F;
// On the edge.
constexpr std::array<float, 3> kElsewhere{0.5F, 0.0F, 1.0F};

// Bins: a block has so many before the next one's turn comes, and then failures are asked again.
constexpr std::size_t kOctave = 8;
// Nothing counts less: a cost of 0 is one that nobody knows.
constexpr float kLeastWeight = 1e-6F;
// A round is over when all have been asked, and less than this share of the tetrahedra went.
constexpr double kIdleShare = 0.02;

}  // namespace

template <class Real>
auto FuseRound<Real>::kind_of(VertexId v) -> Kind {
  for (std::size_t k = 0; k < width_; ++k) {
    if (!std::isfinite(mesh_->steering[v * width_ + k])) return kOut;
  }
  const std::uint8_t marks = mesh_->marks[v];
  if ((marks & kOnInterface) != 0) return kOut;
  if ((marks & kLocked) != 0) return kTarget;
  if (!limits_->sheets_move()) return (marks & kOnBoundary) != 0 ? kTarget : kFree;
  return kind_on_sheet(v);
}

template <class Real>
void FuseRound<Real>::begin(const FuseLimits& limits, std::span<const SteeringField> fields,
                            WorkMesh<Real>* mesh) {
  limits_ = &limits;
  fields_ = fields;
  mesh_ = mesh;
  width_ = mesh->steering_width;
  cavity_.begin(mesh, &balls_, limits.min_quality, limits.unit);
  std::size_t steering_columns = 0;
  for (const SteeringField& f : fields) {
    if (f.column != kNoColumn && is_float(mesh->point_columns[f.column].type)) ++steering_columns;
  }
  interpolates_ = !limits.keep_integrals && steering_columns < mesh->point_columns.size();
  edge_costs_.begin(mesh, fields, limits.unit, limits.sheet_weight);
  paper_.begin(limits.paper, fields, mesh);
  integrals_.begin(limits.keep_integrals, fields, mesh);
  errors_.begin(fields, {limits.max_error, limits.error_now, limits.unit, limits.max_deviation},
                mesh, &balls_);
  begin_weights();
  values_.resize(width_);
  least_.resize(width_);
  most_.resize(width_);

  const std::size_t n = mesh->vertex_count();
  balls_.reset(n, mesh->tets);
  if (limits.sheets_move()) begin_sheets();
  state_.assign(n, State{});
  for (VertexId v = 0; v < n; ++v) state_[v].kind = kind_of(v);
  candidates_.resize(n);  // nobody looks at them before they are judged
  stamped_ = 0;
  now_ = 1;
  queue_.reset(n);
  failures_.clear();
  slides_ = 0;
  slid_ = 0;
  not_slid_ = 0;
  turns_over_ = false;
  removed_ = 0;
  fused_ = 0;
  losses_ = 0;
  interpolations_.clear();
}

template <class Real>
void FuseRound<Real>::begin_weights() {
  weights_.clear();
  const std::uint32_t number = limits_->weights.column;
  const bool of_cells = limits_->weights.of_cells;
  if (number == kNoColumn) return;
  const Column& column = of_cells ? mesh_->cell_columns[number] : mesh_->point_columns[number];
  if (of_cells) weights_.assign(mesh_->vertex_count(), 0);
  visit_type(column.type, [&](auto zero) {
    using T = decltype(zero);
    const T* const rows = reinterpret_cast<const T*>(column.rows.data());
    for (std::size_t v = 0; v < mesh_->vertex_count() && !of_cells; ++v) {
      weights_.push_back(static_cast<float>(rows[v]));
    }
    for (TetId t = 0; t < mesh_->tets.size() && of_cells; ++t) {
      const auto weight = static_cast<float>(rows[t]);
      for (const VertexId v : mesh_->tets[t]) weights_[v] = std::max(weights_[v], weight);
    }
  });
}

template <class Real>
float FuseRound<Real>::weight_of(VertexId v, VertexId partner) const {
  if (weights_.empty()) return 1;
  const float weight = std::max({weights_[v], weights_[partner], kLeastWeight});
  return weight * weight;
}

// Weights multiply what it costs, too: so much less is added.
template <class Real>
void FuseRound<Real>::add_gradient_variances() {
  const auto variance = static_cast<float>(limits_->gradient_variance);
  for (VertexId v = 0; v < state_.size(); ++v) {
    add_gradient_variance(variance / weight_of(v, v),
                          mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width);
  }
}

template <class Real>
FuseStatistics FuseRound<Real>::run(const FuseLimits& limits, std::span<const SteeringField> fields,
                                    WorkMesh<Real>* mesh, FusionLog* log) {
  begin(limits, fields, mesh);
  if (limits.gradient_variance > 0) add_gradient_variances();
  notes_.begin(mesh, log);
  work();
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
  for (VertexId v = 0; v < state_.size(); ++v) {
    if (mesh_->incidence[v] == 0) continue;
    float least = 0, failed = 0;
    const Reject reason = look_back(v, &least, &failed);
    // Of several chunks that have a vertex one counts it.
    const bool is_elsewhere = (mesh_->marks[v] & (kOnInterface | kLast)) == kOnInterface;
    if (!is_elsewhere) ++pass.rejected[static_cast<std::size_t>(reason)];
    known_cost(v) = failed > 0 ? -failed : least;
    if (least > 0) ++statistics->costs[cost_bin(least)];
    if (limits_->facing_after != nullptr) {
      sheets_.note_facing(v, limits_->marks_are_known, limits_->facing_after);
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
  if (!may_move(v)) {
    const std::uint8_t marks = mesh_->marks[v];
    if ((marks & kOnInterface) != 0) return Reject::kInterface;
    return (marks & kOnBoundary) != 0 ? Reject::kBoundary : Reject::kLocked;
  }
  const auto threshold = static_cast<float>(limits_->threshold);
  if (knows_candidates(v) || !(known_cost(v) > 0)) {
    if (!knows_candidates(v)) judge(v);
    for (const Candidate& c : candidates_[v]) {
      if (c.partner == kNoVertex) break;
      if (state_[c.partner].changed > state_[v].judged) continue;
      if (c.cost <= threshold && state_[v].failed >= state_[v].moved) {
        if (*failed == 0) *failed = c.cost;
      } else if (*least == 0) {
        *least = c.cost;
      }
    }
  } else {
    *least = known_cost(v);
  }
  if (*failed > 0) return static_cast<Reject>(state_[v].reason);
  return *least > 0 && *least <= threshold && quota_is_met() ? Reject::kQuota : Reject::kError;
}

// Vertices take turns, those with the cheapest candidates first; but a block has an octave of turns
// before the next one. Where a fusion failed, the vertex is asked again when something near it has
// moved.
template <class Real>
void FuseRound<Real>::work() {
  for (VertexId v = 0; v < state_.size(); ++v) {
    if (may_move(v)) wait(v, std::abs(known_cost(v)));
  }
  const std::size_t end = CostQueue::bin_of(static_cast<float>(limits_->threshold)) + 1;
  std::uint64_t removed_before = 0;
  do {
    removed_before = removed_;
    for (std::size_t bin = 0; bin < end; bin += kOctave) {
      ask_again(Edges::kOwn);
      for (std::size_t block = 0; block < queue_.blocks(); ++block) {
        work_on(block, bin, std::min(bin + kOctave, end));
      }
    }
    for (std::size_t block = 0; block < queue_.blocks(); ++block) queue_.go_to(block, 0);
    const auto left = static_cast<double>(mesh_->tets.size() - removed_);
    if (static_cast<double>(removed_ - removed_before) < kIdleShare * left) return;
    turns_over_ = true;
  } while (!quota_is_met() && ask_again(Edges::kAll));
}

// For the vertex's turn, if it comes in this round: a vertex that waits does so until then.
template <class Real>
bool FuseRound<Real>::wait(VertexId v, float cost) {
  if (!(cost <= static_cast<float>(limits_->threshold))) return false;
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
      ask_ahead(queue_.first(block));
      if (mesh_->incidence[v] != 0) visit(v);
    }
  }
  queue_.go_to(block, end);
}

// For what is known of the vertices whose turn comes next.
template <class Real>
void FuseRound<Real>::ask_ahead(VertexId next) const {
  if (next == kNoVertex) return;
  balls_.ask_for_tets(next, mesh_->tets);
  const VertexId second = queue_.after(next);
  if (second == kNoVertex) return;
  balls_.ask_for_entries(second);
  const VertexId third = queue_.after(second);
  if (third == kNoVertex) return;
  balls_.ask_for_place(third);
  __builtin_prefetch(&state_[third]);
  __builtin_prefetch(&candidates_[third]);
  __builtin_prefetch(&mesh_->incidence[third]);
}

// Where something near has moved since. What had its quadric last has judged its edges itself. With
// all edges, those that were the other end's business get another try, too: from here.
template <class Real>
bool FuseRound<Real>::ask_again(Edges edges) {
  bool any = false;
  std::size_t kept = 0;
  for (const VertexId v : failures_) {
    state_[v].listed = false;
    if (mesh_->incidence[v] == 0 || state_[v].failed < state_[v].changed) continue;
    if (state_[v].moved > state_[v].failed) {
      if (edges == Edges::kAll) judge(v, edges);
      state_[v].place = 0;
      const Candidate* c = next_candidate(v);
      if (c != nullptr && wait(v, c->cost)) {
        any = true;
        continue;
      }
      state_[v].failed = now_;
    }
    state_[v].listed = true;
    failures_[kept++] = v;
  }
  failures_.resize(kept);
  return any;
}

// The cheapest candidate of v that is neither used up nor out of date; those before are.
template <class Real>
auto FuseRound<Real>::next_candidate(VertexId v) -> const Candidate* {
  for (std::uint8_t& i = state_[v].place; i < kCandidates; ++i) {
    const Candidate& c = candidates_[v][i];
    if (c.partner == kNoVertex) return nullptr;
    if (state_[c.partner].changed <= state_[v].judged && !is_refused(v, c)) return &c;
  }
  return nullptr;
}

// It has failed, and most likely would again: what it was refused for is as it was when the vertex
// last failed.
template <class Real>
bool FuseRound<Real>::is_refused(VertexId v, const Candidate& candidate) const {
  if (candidate.refused_by == kNoTet || turns_over_) return false;
  const Tet& tet = mesh_->tets[candidate.refused_by];
  if (is_deleted(tet)) return false;
  for (const VertexId corner : tet) {
    if (state_[corner].changed > state_[v].failed) return false;
  }
  return true;
}

// Tries the vertex's candidates whose turn has come, up to the first that it may fuse with.
template <class Real>
void FuseRound<Real>::visit(VertexId v) {
  if (!knows_candidates(v)) judge(v);
  while (true) {
    const Candidate* c = next_candidate(v);
    if (c == nullptr || c->cost > limits_->threshold) return;
    if (CostQueue::bin_of(c->cost) > bin_) {
      queue_.push(v, c->cost);
      return;
    }
    const VertexId partner = c->partner;
    if (fuse(v, Candidate(*c))) {
      const VertexId kept = mesh_->incidence[v] != 0 ? v : partner;
      if (!may_move(kept)) return;
      judge(kept);
      if (const Candidate* next = next_candidate(kept)) wait(kept, next->cost);
      return;
    }
    if (dear_ > 0) {
      raise_cost(v);
      continue;
    }
    note_reason(v);
    candidates_[v][state_[v].place].refused_by = refused_by_;
    ++state_[v].place;
    if (!state_[v].listed) failures_.push_back(v);
    state_[v].listed = true;
    state_[v].failed = now_;
  }
}

// One reason may stand for several candidates. A bound is the one that somebody may want to change.
template <class Real>
void FuseRound<Real>::note_reason(VertexId v) {
  constexpr auto kBound = static_cast<std::uint8_t>(Reject::kDeviation);
  if (state_[v].failed >= state_[v].moved && state_[v].reason == kBound) return;
  state_[v].reason = static_cast<std::uint8_t>(reject_);
}

template <class Real>
bool FuseRound<Real>::fuse(VertexId v, const Candidate& candidate) {
  const VertexId partner = candidate.partner;
  dear_ = 0;
  refused_by_ = kNoTet;
  if (!plan(v, partner)) return false;
  if (removed_ + cavity_.deleted().size() > limits_->quota) {
    reject_ = Reject::kQuota;
    return false;
  }
  const VertexId kept = fixed_ ? partner : std::min(v, partner);
  if (!fixed_ && !judges_values()) choose_values(v, partner);
  interpolation_.to = kept;
  if (!fixed_ && interpolates_) interpolations_.push_back(interpolation_);
  apply(v, partner, kept, notes_.are_wanted() ? error_of(v, candidate) : 0);
  return true;
}

// Finds a position that is allowed, and the cavity.
template <class Real>
bool FuseRound<Real>::plan(VertexId v, VertexId partner) {
  if (is_on_sheet(v)) return plan_on_sheet(v, partner);
  fixed_ = state_[partner].kind != state_[v].kind;
  if (fixed_) {
    position_ = mesh_->positions[partner];
    if (allows(v, partner)) return true;
    note_refusal();
    return false;
  }
  const MergedQuadric& merged = edge_costs_.merge(v, partner);
  position_ = edge_costs_.place(v, merged.best);
  if (allows(v, partner)) return true;
  note_refusal();
  const float weight = merged.sum[kQuadricW];
  const float most =
      std::min(kSlack * std::max(value_at(merged.reduced, merged.best), 1e-12F * weight),
               threshold_for(v, partner) * weight);
  return push(v, partner, most) || (dear_ == 0 && slide(v, partner, most));
}

template <class Real>
void FuseRound<Real>::note_refusal() {
  if (reject_ == Reject::kFlip || reject_ == Reject::kQuality) refused_by_ = cavity_.refused_by();
}

// Off the tetrahedron that speaks against a position, by the way that costs least.
template <class Real>
bool FuseRound<Real>::push(VertexId v, VertexId partner, float most) {
  if (reject_ != Reject::kFlip && reject_ != Reject::kQuality) return false;
  const auto [direction, distance] = cavity_.obstacle();
  const Reduced& reduced = edge_costs_.merged().reduced;
  Offset u = edge_costs_.offset(mesh_->positions[v], position_);
  const Offset step = cheapest_step(reduced, direction, distance, kPushPull);
  for (std::size_t i = 0; i < 3; ++i) u[i] += step[i];
  if (!(value_at(reduced, u) <= most)) return false;
  position_ = edge_costs_.place(v, u);
  return allows(v, partner);
}

// Where little comes of it, as on a Delaunay mesh, only now and then, until the turns are over.
template <class Real>
bool FuseRound<Real>::sliding_pays() {
  constexpr std::uint64_t kFirst = 1024, kWorth = 100, kNowAndThen = 8;
  return limits_->thorough || turns_over_ || slides_ < kFirst + kWorth * slid_ ||
         ++not_slid_ % kNowAndThen == 0;
}

// Along the edge, away from what speaks against a position; at its ends one of the two stays where
// it is, as suits layers and lattices.
template <class Real>
bool FuseRound<Real>::slide(VertexId v, VertexId partner, float most) {
  if (!sliding_pays()) return false;
  refused_by_ = kNoTet;  // these places, too, may be allowed another time
  const Reject reason = reject_;
  const MergedQuadric& merged = edge_costs_.merged();
  for (const float t : kElsewhere) {
    const Offset u{t * merged.edge[0], t * merged.edge[1], t * merged.edge[2]};
    if (!(value_at(merged.reduced, u) <= most)) continue;
    position_ = edge_costs_.place(v, u);
    ++slides_;
    if (!allows(v, partner)) continue;
    ++slid_;
    return true;
  }
  reject_ = reason;
  return false;
}

template <class Real>
bool FuseRound<Real>::allows(VertexId v, VertexId partner) {
  dear_ = 0;
  const auto reason = cavity_.collect(v, partner, fixed_, position_);
  reject_ = reason.value_or(Reject::kSurface);
  if (reason || (is_on_sheet(v) && !sheet_fusion_.allows(position_))) return false;
  if (loses_too_much(v, partner)) {
    reject_ = Reject::kError;
    return false;
  }
  const auto speaks = judges_values() ? judge_values(v, partner) : std::nullopt;
  reject_ = speaks.value_or(reject_);
  if (speaks) return false;
  // What is locked may be so because the mesh is broken there.
  if (!fixed_ || is_on_sheet(v) || (mesh_->marks[partner] & kLocked) == 0) return true;
  reject_ = Reject::kLocked;
  return !cavity_.doubles_faces(v, partner);
}

// Of the candidate in hand, which comes in a later round, or never.
template <class Real>
void FuseRound<Real>::raise_cost(VertexId v) {
  Candidates& all = candidates_[v];
  std::size_t at = state_[v].place;
  const Candidate raised{dear_, all[at].partner, kNoTet};
  for (; at + 1 < kCandidates && all[at + 1].cost < dear_; ++at) all[at] = all[at + 1];
  all[at] = raised;
}

template <class Real>
void FuseRound<Real>::apply(VertexId v, VertexId partner, VertexId kept, float error) {
  ++now_;
  const VertexId gone = kept == v ? partner : v;
  if (notes_.are_wanted()) note(kept, gone);
  if (errors_.bounds()) errors_.apply();
  if (integrals_.stay()) integrals_.apply(kept, interpolation_.nearest);
  if (!fixed_) mesh_->marks[kept] |= kMoved;
  if (!weights_.empty()) weights_[kept] = std::max(weights_[v], weights_[partner]);
  merge_quadrics(v, kept);
  move_tets(kept, gone);
  removed_ += cavity_.deleted().size();
  ++fused_;
  losses_ += loss_;
  state_[v].changed = now_;
  state_[partner].changed = now_;
  cavity_.note_fused(kept);
  if (!notes_.are_wanted()) return;
  carry_rows(kept);
  notes_.after(error);
}

template <class Real>
void FuseRound<Real>::note(VertexId kept, VertexId gone) {
  const auto add = [&](std::uint32_t entry, bool was_gone) {
    notes_.star().push_back({entry >> 2, static_cast<std::uint8_t>(entry & 3u), was_gone});
  };
  for (const std::uint32_t entry : cavity_.affected()) {
    add(entry, mesh_->tets[entry >> 2][entry & 3u] == gone);
  }
  if (fixed_) {
    for (const std::uint32_t entry : ball(kept)) {
      const Tet& tet = mesh_->tets[entry >> 2];
      if (std::find(tet.begin(), tet.end(), gone) == tet.end()) add(entry, false);
    }
  }
  notes_.before(kept, {&gone, 1}, cavity_.deleted());
}

// What compact() does for all at once: whoever notes rows wants them as they are now.
template <class Real>
void FuseRound<Real>::carry_rows(VertexId kept) {
  for (Column& column : mesh_->point_columns) interpolate_point_column(interpolations_, &column);
  interpolations_.clear();
  if (may_move(kept)) write_steering_columns(fields_, {&kept, 1}, mesh_);
}

// One that stays where it is keeps its values, too.
template <class Real>
void FuseRound<Real>::merge_quadrics(VertexId v, VertexId kept) {
  const std::size_t size = mesh_->quadric_width;
  float* row = mesh_->quadrics.data() + kept * size;
  double* values = mesh_->steering.data() + kept * width_;
  if (is_on_sheet(v)) {
    mesh_->deviations[kept] = sheet_fusion_.deviation();
    sheet_fusion_.note_fused(kept);
  }
  if (fixed_) {
    edge_costs_.add(v, mesh_->positions[kept], values, row);
    if (is_on_sheet(v)) edge_costs_.add_sheet(v, mesh_->positions[kept], row);
    return;
  }
  std::fill_n(row, size, 0.0F);
  edge_costs_.add_merged(v, position_, values_.data(), row);
  if (is_on_sheet(v)) edge_costs_.add_merged_sheet(v, position_, row);
  std::copy(values_.begin(), values_.end(), values);
  mesh_->positions[kept] = position_;
}

template <class Real>
void FuseRound<Real>::move_tets(VertexId kept, VertexId gone) {
  WorkMesh<Real>& mesh = *mesh_;
  for (const TetId t : cavity_.deleted()) {
    for (const VertexId v : mesh.tets[t]) {
      --mesh.incidence[v];
      state_[v].moved = now_;
    }
    mark_deleted(&mesh.tets[t]);
  }
  for (const std::uint32_t entry : cavity_.affected()) {
    Tet& tet = mesh.tets[entry >> 2];
    tet[entry & 3u] = kept;
    for (const VertexId v : tet) state_[v].moved = now_;
  }
  mesh.incidence[gone] = 0;
  balls_.clear(gone);
  if (!fixed_) {
    mesh.incidence[kept] = 0;
    balls_.clear(kept);
  }
  ball(kept);  // drops what is gone
  balls_.add(kept, cavity_.affected());
  mesh.incidence[kept] += static_cast<std::uint32_t>(cavity_.affected().size());
}

template <class Real>
void FuseRound<Real>::compact() {
  WorkMesh<Real>& mesh = *mesh_;
  if (fused_ == 0) return;
  if (interpolates_) {
    for (Column& column : mesh.point_columns) interpolate_point_column(interpolations_, &column);
  }
  std::vector<VertexId> moved;
  for (VertexId v = 0; v < state_.size(); ++v) {
    if (state_[v].changed != 1 && may_move(v)) moved.push_back(v);
  }
  write_steering_columns(fields_, moved, &mesh);
  std::size_t tets = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (is_deleted(mesh.tets[t])) continue;
    mesh.tets[tets] = mesh.tets[t];
    if (mesh.removed.wanted()) mesh.removed.first[tets] = mesh.removed.first[t];
    for (Column& column : mesh.cell_columns) column.move_row(t, tets);
    ++tets;
  }
  mesh.resize_tets(tets);
  const Vector<VertexId> new_ids = drop_unused_vertices(&mesh);
  for (Tet& t : mesh.tets) {
    for (VertexId& v : t) v = new_ids[v];
  }
}

template class FuseRound<float>;
template class FuseRound<double>;

}  // namespace tetfusion
