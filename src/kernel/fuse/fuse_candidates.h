// With whom the vertices of a mesh may be fused, and what that costs: of each the cheapest few.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "kernel/fuse/fuse_limits.h"
#include "kernel/fuse/fuse_vertices.h"
#include "kernel/quadrics/edge_costs.h"
#include "kernel/sheets/sheets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

struct FuseCandidate {
  float cost;
  VertexId partner;
  TetId refused_by;  // what the best position was refused for; kNoTet: it was not, or nobody knows
};

// Keeps its memory from mesh to mesh. Not thread-safe.
//
// An edge is judged once, by the end that got its quadric last. So candidates of a vertex go out of
// date when a partner has got another quadric: that one has judged the edge then. But one that
// stays in its place judges none: the edge to it comes again when v is judged anew.
template <class Real>
class FuseCandidates {
 public:
  static constexpr std::size_t kMost = 8;

  // All outlive this.
  void begin(const FuseLimits& limits, const WorkMesh<Real>* mesh, FuseVertices<Real>* vertices,
             EdgeCosts<Real>* edge_costs);

  enum class Edges : std::uint8_t { kOwn, kAll };  // of a vertex: to be judged by it, or any
  // Chooses the cheapest partners of v. Of those whose turn does not come in this round one is
  // enough.
  void judge(VertexId v, Edges edges = Edges::kOwn);
  // Has v been judged since it got its quadric?
  bool are_known(VertexId v) const { return state(v).is_judged(); }

  // The cheapest candidate of v that is neither used up nor out of date, nor refused by what is as
  // it was; those before are used up. Null: there is none.
  const FuseCandidate* next(VertexId v);
  // What next() has given could not be fused with: it is used up ...
  void use_up(VertexId v, TetId refused_by) {
    of(v)[state(v).next_candidate].refused_by = refused_by;
    ++state(v).next_candidate;
  }
  // ... or should have cost so much more, and comes later, or never.
  void raise_cost(VertexId v, float cost);
  // None is used up.
  void begin_again(VertexId v) { state(v).next_candidate = 0; }
  // From now on who was refused is asked in any case.
  void ask_refused_ones() { asks_refused_ones_ = true; }

  // Calls use(candidate) with those of v that are not out of date, used up or not, from the
  // cheapest on. They are known.
  template <class Use>
  void for_each(VertexId v, Use use) const {
    for (const FuseCandidate& c : candidates_[v]) {
      if (c.partner == kNoVertex) return;
      if (!is_out_of_date(v, c)) use(c);
    }
  }

  // Asks the processor for what is known of v, then for what its next candidate is.
  void prefetch_list(VertexId v) const { __builtin_prefetch(&candidates_[v]); }
  void prefetch_partner(VertexId v) const {
    if (!are_known(v) || state(v).next_candidate >= kMost) return;
    const VertexId u = candidates_[v][state(v).next_candidate].partner;
    if (u == kNoVertex) return;
    __builtin_prefetch(&state(u));
    __builtin_prefetch(&mesh_->positions[u]);
    __builtin_prefetch(mesh_->quadrics.data() + std::size_t{u} * mesh_->quadric_width);
    vertices_->balls().prefetch_ball(u);
  }

 private:
  using Candidates = std::array<FuseCandidate, kMost>;  // ascending by cost
  static constexpr FuseCandidate kNone{std::numeric_limits<float>::infinity(), kNoVertex, kNoTet};
  using State = typename FuseVertices<Real>::State;

  State& state(VertexId v) { return (*vertices_)[v]; }
  const State& state(VertexId v) const { return (*vertices_)[v]; }
  Candidates& of(VertexId v) { return candidates_[v]; }
  bool is_out_of_date(VertexId v, const FuseCandidate& candidate) const {
    return state(candidate.partner).changed > state(v).judged;
  }
  bool is_refused(VertexId v, const FuseCandidate& candidate) const;
  void find_partners(VertexId v);
  void find_partners_on_sheet(VertexId v);
  std::size_t choose_partners(VertexId v, Edges edges);
  void find_costs(VertexId v, std::size_t movable);
  void keep_cheapest(VertexId v);

  const FuseLimits* limits_ = nullptr;
  const WorkMesh<Real>* mesh_ = nullptr;
  FuseVertices<Real>* vertices_ = nullptr;
  EdgeCosts<Real>* edge_costs_ = nullptr;
  Vector<Candidates> candidates_;
  bool asks_refused_ones_ = false;

  // Of the vertex in hand: its neighbours, then those that were chosen (choose_partners()), and
  // what that takes; what fusions with them cost, and their ranks in the order of costs.
  std::uint32_t stamped_ = 0;
  Vector<VertexId> partners_, chosen_, fixed_ones_;
  Vector<float> costs_;
  Vector<std::int32_t> ranks_;
  Vector<FuseCandidate> sorted_;
  SheetFan fan_;
};

extern template class FuseCandidates<float>;
extern template class FuseCandidates<double>;

}  // namespace tetfusion
