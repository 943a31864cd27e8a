// What a round of fuse knows of its mesh's vertices: what each may do, how much errors count there,
// and when what happened to it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "kernel/fuse/fuse_limits.h"
#include "kernel/live_balls.h"
#include "kernel/quadrics/edge_costs.h"
#include "kernel/sheets/sheets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class FuseVertices {
 public:
  enum Kind : std::uint8_t {
    kFree,     // inside: may be fused
    kOnSheet,  // may be fused along a sheet; others may come to it
    kOnLine,   // the same, along a line of a sheet
    kTarget,   // stays where it is; others may come to it
    kOut,      // neither
  };

  // Of a vertex, in one place: whoever looks at a neighbour wants most of it. Events have numbers,
  // ascending from that of the beginning.
  struct State {
    static constexpr std::uint32_t kBeginning = 1;
    std::uint32_t stamp = 0;             // the last search for neighbours that has found it
    std::uint32_t changed = kBeginning;  // it got its quadric
    std::uint32_t judged = 0;            // its candidates were chosen
    std::uint32_t failed = 0;            // one of them could not be fused with
    std::uint32_t moved = kBeginning;    // its ball changed
    Kind kind = kOut;
    std::uint8_t reason = 0;          // why the last fusion of it failed
    std::uint8_t next_candidate = 0;  // in its candidates: those before are used up
    bool listed = false;              // among the failures

    bool is_judged() const { return judged > changed; }
    bool has_failed() const { return failed >= moved; }  // and nothing near it has moved since
    bool has_fused() const { return changed != kBeginning; }
    bool is_as_it_began() const { return moved == kBeginning; }
  };

  // Both outlive this. Whoever fuses vertices tells of it: the mesh's incidence, balls() and the
  // states are to stay right. A vertex on a sheet that may move gets its sheet's quadric when it is
  // first free.
  void begin(const FuseLimits& limits, WorkMesh<Real>* mesh);

  std::size_t size() const { return states_.size(); }
  State& operator[](VertexId v) { return states_[v]; }
  const State& operator[](VertexId v) const { return states_[v]; }
  bool may_move(VertexId v) const { return states_[v].kind < kTarget; }
  bool is_on_sheet(VertexId v) const {
    return states_[v].kind == kOnSheet || states_[v].kind == kOnLine;
  }
  Along along(VertexId v) const {
    return states_[v].kind == kOnLine ? Along::kLine : Along::kSheet;
  }

  // The last event.
  std::uint32_t now() const { return now_; }
  std::uint32_t next_event() { return ++now_; }

  // What a fusion of these costs, as a multiple of what it does; and what it may cost without that.
  float cost_factor(VertexId v, VertexId partner) const {
    if (weights_.empty()) return 1;
    // Not 0: that is a cost that nobody knows.
    const float weight = std::max({weights_[v], weights_[partner], WeightColumn::kLeast});
    return weight * weight;  // costs are squares of errors
  }
  float threshold_for(VertexId v, VertexId partner) const {
    return static_cast<float>(limits_->threshold) / cost_factor(v, partner);
  }
  bool have_weights() const { return !weights_.empty(); }
  // In this round the vertex that they become counts like the one of them that counts most; from
  // the next one on by the column, whose value is interpolated.
  void join_weights(VertexId v, VertexId partner, VertexId kept) {
    if (have_weights()) weights_[kept] = std::max(weights_[v], weights_[partner]);
  }

  std::span<const std::uint32_t> ball(VertexId v) {
    return balls_.of(v, mesh_->incidence[v], mesh_->tets);
  }
  LiveBalls& balls() { return balls_; }
  const LiveBalls& balls() const { return balls_; }
  Sheets<Real>& sheets() { return sheets_; }

 private:
  Kind kind_of(VertexId v);
  Kind kind_on_sheet(VertexId v);
  bool is_on_one(VertexId v) const {
    return (mesh_->marks[v] & kOnBoundary) != 0 || sheets_.is_between_regions(v);
  }
  void begin_sheets();
  void begin_weights();

  const FuseLimits* limits_ = nullptr;
  WorkMesh<Real>* mesh_ = nullptr;
  Vector<State> states_;
  Vector<float> weights_;  // of errors; none if all count alike
  LiveBalls balls_;
  Sheets<Real> sheets_;
  std::uint32_t now_ = 0;
};

extern template class FuseVertices<float>;
extern template class FuseVertices<double>;

}  // namespace tetfusion
