#include "kernel/fuse/fuse_candidates.h"

#include <algorithm>
#include <utility>

#include "kernel/quadrics/cost_order.h"

namespace tetfusion {

template <class Real>
void FuseCandidates<Real>::begin(const FuseLimits& limits, const WorkMesh<Real>* mesh,
                                 FuseVertices<Real>* vertices, EdgeCosts<Real>* edge_costs) {
  limits_ = &limits;
  mesh_ = mesh;
  vertices_ = vertices;
  edge_costs_ = edge_costs;
  candidates_.resize(mesh->vertex_count());  // nobody looks at them before they are judged
  asks_refused_ones_ = false;
  stamped_ = 0;
}

template <class Real>
void FuseCandidates<Real>::judge(VertexId v, Edges edges) {
  vertices_->is_on_sheet(v) ? find_partners_on_sheet(v) : find_partners(v);
  find_costs(v, choose_partners(v, edges));
  keep_cheapest(v);
  state(v).next_candidate = 0;
  state(v).judged = vertices_->next_event();
}

// All neighbours.
template <class Real>
void FuseCandidates<Real>::find_partners(VertexId v) {
  const std::uint32_t stamp = ++stamped_;
  state(v).stamp = stamp;
  const auto entries = vertices_->ball(v);
  partners_.resize(3 * entries.size());
  VertexId* end = partners_.data();
  for (const std::uint32_t entry : entries) {
    const Tet& tet = mesh_->tets[entry >> 2];
    // No branch: whether somebody has been seen cannot be foretold.
    for (std::size_t i = 1; i < 4; ++i) {
      const VertexId u = tet[(entry + i) & 3u];
      *end = u;
      end += state(u).stamp != stamp ? 1 : 0;
      state(u).stamp = stamp;
    }
  }
  partners_.resize(static_cast<std::size_t>(end - partners_.data()));
}

// Those along edges of the sheet, or of the line.
template <class Real>
void FuseCandidates<Real>::find_partners_on_sheet(VertexId v) {
  partners_.clear();
  const bool is_line = vertices_->along(v) == Along::kLine;
  if (!vertices_->sheets().find_fan(v, &fan_) || (is_line && fan_.sharp_edges != 2)) return;
  // A larger feature angle makes corners, where lines end, parts of their sheets.
  const bool may_end = limits_->feature_angle > kFeatureAngle;
  for (std::size_t i = 0; i < fan_.size(); ++i) {
    const VertexId u = fan_.ring[i];
    const bool is_inside = state(u).kind == FuseVertices<Real>::kOnSheet;
    const bool leaves_line = fan_.sharp[i] == 0 || (is_inside && !may_end);
    if (is_line && leaves_line) continue;
    partners_.push_back(u);
  }
}

// Leaves those of the neighbours with which v may be fused in its own turn: those that may move,
// and behind them those that stay. Returns how many are the former. An edge whose other end has
// been judged since v got its quadric is that one's business, unless all are asked for.
template <class Real>
std::size_t FuseCandidates<Real>::choose_partners(VertexId v, Edges edges) {
  chosen_.resize(partners_.size());
  fixed_ones_.resize(partners_.size());
  const auto kind = state(v).kind;
  constexpr std::uint32_t kAlways = std::numeric_limits<std::uint32_t>::max();
  const std::uint32_t changed = edges == Edges::kAll ? kAlways : state(v).changed;
  std::size_t movable = 0, fixed = 0;
  for (const VertexId u : partners_) {
    const State& other = state(u);
    const bool is_own = other.judged <= std::max(other.changed, changed);
    // No branch, as in find_partners().
    chosen_[movable] = u;
    movable += static_cast<std::size_t>(other.kind == kind) & static_cast<std::size_t>(is_own);
    fixed_ones_[fixed] = u;
    fixed += static_cast<std::size_t>(other.kind != kind) &
             static_cast<std::size_t>(other.kind != FuseVertices<Real>::kOut);
  }
  chosen_.resize(movable);
  fixed_ones_.resize(fixed);
  chosen_.insert(chosen_.end(), fixed_ones_.begin(), fixed_ones_.end());
  std::swap(partners_, chosen_);
  return movable;
}

// Of v and each of the partners, of whom so many move, too.
template <class Real>
void FuseCandidates<Real>::find_costs(VertexId v, std::size_t movable) {
  const std::size_t count = partners_.size();
  costs_.resize(count + kLanes);
  if (vertices_->is_on_sheet(v)) {
    const Along along = vertices_->along(v);
    for (std::size_t i = 0; i < count; ++i) {
      costs_[i] = i < movable ? edge_costs_->between_on_sheet(v, partners_[i], along)
                              : edge_costs_->onto_on_sheet(v, partners_[i]);
    }
  } else {
    edge_costs_->between(v, {partners_.data(), movable}, costs_.data());
    for (std::size_t i = movable; i < count; ++i) {
      costs_[i] = edge_costs_->onto(v, partners_[i]);
    }
  }
  if (!vertices_->have_weights()) return;
  for (std::size_t i = 0; i < count; ++i) costs_[i] *= vertices_->cost_factor(v, partners_[i]);
}

// No branch, as in find_partners(): those whose turn comes in this round to the front, and the
// cheapest of the others. What is no number is none of these.
template <class Real>
void FuseCandidates<Real>::keep_cheapest(VertexId v) {
  const float threshold =
      std::min(static_cast<float>(limits_->threshold), std::numeric_limits<float>::max());
  FuseCandidate dear = kNone;
  std::size_t cheap = 0;
  for (std::size_t i = 0; i < partners_.size(); ++i) {
    const float cost = costs_[i];
    const VertexId partner = partners_[i];
    costs_[cheap] = cost;
    partners_[cheap] = partner;
    cheap += cost <= threshold ? 1 : 0;
    const float otherwise = cost <= threshold ? kNone.cost : cost;
    dear.partner = otherwise < dear.cost ? partner : dear.partner;
    dear.cost = std::min(dear.cost, otherwise);  // in this order, for what is no number
  }
  ranks_.resize(cheap + kLanes);
  find_ranks(cheap, costs_.data(), ranks_.data());
  sorted_.resize(cheap + kMost);
  for (std::size_t i = 0; i < cheap; ++i) {
    sorted_[static_cast<std::size_t>(ranks_[i])] = {costs_[i], partners_[i], kNoTet};
  }
  sorted_[cheap] = dear;
  sorted_[cheap + 1] = kNone;
  std::copy_n(sorted_.begin(), kMost, of(v).begin());
}

template <class Real>
auto FuseCandidates<Real>::next(VertexId v) -> const FuseCandidate* {
  for (std::uint8_t& i = state(v).next_candidate; i < kMost; ++i) {
    const FuseCandidate& c = of(v)[i];
    if (c.partner == kNoVertex) return nullptr;
    if (!is_out_of_date(v, c) && !is_refused(v, c)) return &c;
  }
  return nullptr;
}

// It has failed, and most likely would again: what it was refused for is as it was when the vertex
// last failed.
template <class Real>
bool FuseCandidates<Real>::is_refused(VertexId v, const FuseCandidate& candidate) const {
  if (candidate.refused_by == kNoTet || asks_refused_ones_) return false;
  const Tet& tet = mesh_->tets[candidate.refused_by];
  if (is_deleted(tet)) return false;
  for (const VertexId corner : tet) {
    if (state(corner).changed > state(v).failed) return false;
  }
  return true;
}

template <class Real>
void FuseCandidates<Real>::raise_cost(VertexId v, float cost) {
  Candidates& all = of(v);
  std::size_t at = state(v).next_candidate;
  const FuseCandidate raised{cost, all[at].partner, kNoTet};
  for (; at + 1 < kMost && all[at + 1].cost < cost; ++at) all[at] = all[at + 1];
  all[at] = raised;
}

template class FuseCandidates<float>;
template class FuseCandidates<double>;

}  // namespace tetfusion
