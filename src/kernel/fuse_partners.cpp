// Of fuse_round.h: with whom a vertex may be fused, and the cheapest of these.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "kernel/cost_order.h"
#include "kernel/fuse_round.h"

namespace tetfusion {

// All neighbours.
template <class Real>
void FuseRound<Real>::find_partners(VertexId v) {
  ++stamped_;
  state_[v].stamp = stamped_;
  const auto entries = ball(v);
  partners_.resize(3 * entries.size());
  VertexId* end = partners_.data();
  for (const std::uint32_t entry : entries) {
    const Tet& tet = mesh_->tets[entry >> 2];
    // No branch: whether somebody has been seen cannot be foretold.
    for (std::size_t i = 1; i < 4; ++i) {
      const VertexId u = tet[(entry + i) & 3u];
      *end = u;
      end += state_[u].stamp != stamped_ ? 1 : 0;
      state_[u].stamp = stamped_;
    }
  }
  partners_.resize(static_cast<std::size_t>(end - partners_.data()));
}

// Leaves those of the neighbours with which v may be fused in its own turn: those that may move,
// and behind them those that stay. Returns how many are the former. An edge whose other end has
// been judged since v got its quadric is that one's business, unless all are asked for.
template <class Real>
std::size_t FuseRound<Real>::choose_partners(VertexId v, Edges edges) {
  chosen_.resize(partners_.size());
  fixed_ones_.resize(partners_.size());
  const Kind kind = state_[v].kind;
  constexpr std::uint32_t kAlways = std::numeric_limits<std::uint32_t>::max();
  const std::uint32_t changed = edges == Edges::kAll ? kAlways : state_[v].changed;
  std::size_t movable = 0, fixed = 0;
  for (const VertexId u : partners_) {
    const State& other = state_[u];
    const bool is_own = other.judged <= std::max(other.changed, changed);
    // No branch, as in find_partners().
    chosen_[movable] = u;
    movable += static_cast<std::size_t>(other.kind == kind) & static_cast<std::size_t>(is_own);
    fixed_ones_[fixed] = u;
    fixed +=
        static_cast<std::size_t>(other.kind != kind) & static_cast<std::size_t>(other.kind != kOut);
  }
  chosen_.resize(movable);
  fixed_ones_.resize(fixed);
  chosen_.insert(chosen_.end(), fixed_ones_.begin(), fixed_ones_.end());
  std::swap(partners_, chosen_);
  return movable;
}

// Chooses the cheapest partners of v. Of those whose turn does not come in this round one is
// enough.
template <class Real>
void FuseRound<Real>::judge(VertexId v, Edges edges) {
  const bool on_sheet = is_on_sheet(v);
  on_sheet ? find_partners_on_sheet(v) : find_partners(v);
  const std::size_t movable = choose_partners(v, edges);
  const std::size_t count = partners_.size();
  costs_.resize(count + kLanes);
  places_.resize(count + kLanes);
  if (on_sheet) {
    for (std::size_t i = 0; i < count; ++i) {
      costs_[i] = i < movable ? edge_costs_.between_on_sheet(v, partners_[i], along(v))
                              : edge_costs_.onto_on_sheet(v, partners_[i]);
    }
  } else {
    edge_costs_.between(v, {partners_.data(), movable}, costs_.data());
    for (std::size_t i = movable; i < count; ++i) {
      costs_[i] = edge_costs_.onto(v, partners_[i]);
    }
  }
  for (std::size_t i = 0; i < count && !weights_.empty(); ++i) {
    costs_[i] *= weight_of(v, partners_[i]);
  }
  find_places(count, costs_.data(), places_.data());
  const auto threshold = static_cast<float>(limits_->threshold);
  Candidates& best = candidates_[v];
  std::size_t cheap = 0, known = 0;
  for (std::size_t i = 0; i < count; ++i) {
    cheap += costs_[i] <= threshold ? 1 : 0;
    known += costs_[i] < std::numeric_limits<float>::infinity() ? 1 : 0;
    const auto place = static_cast<std::size_t>(places_[i]);
    if (place < kCandidates) best[place] = {costs_[i], partners_[i], kNoTet};
  }
  const std::size_t kept = std::min(cheap + 1, known);
  if (kept < kCandidates) best[kept] = kNoCandidate;
  state_[v].place = 0;
  state_[v].judged = ++now_;
}

template void FuseRound<float>::find_partners(VertexId);
template std::size_t FuseRound<float>::choose_partners(VertexId, Edges);
template void FuseRound<float>::judge(VertexId, Edges);
template void FuseRound<double>::find_partners(VertexId);
template std::size_t FuseRound<double>::choose_partners(VertexId, Edges);
template void FuseRound<double>::judge(VertexId, Edges);

}  // namespace tetfusion
