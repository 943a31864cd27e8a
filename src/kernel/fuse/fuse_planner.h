// May two neighbours become one, where, and with which values?
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "kernel/criteria.h"
#include "kernel/edge_links.h"
#include "kernel/fuse/fuse_candidates.h"
#include "kernel/fuse/fuse_cavity.h"
#include "kernel/fuse/fuse_limits.h"
#include "kernel/fuse/fuse_values.h"
#include "kernel/fuse/fuse_vertices.h"
#include "kernel/joining.h"
#include "kernel/quadrics/edge_costs.h"
#include "kernel/sheets/boundary_triangles.h"
#include "kernel/sheets/sheet_fusion.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Why two may not become one: one reason for all places that were tried.
struct FuseRefusal {
  Reject reason{};
  float dear = 0;  // if it would cost more than the round may: how much
  // As long as this is as it is, it is of no use to ask again; kNoTet: it may be of use.
  TetId until_changed = kNoTet;
};

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class FusePlanner {
 public:
  // All outlive this.
  void begin(const FuseLimits& limits, std::span<const SteeringField> fields, WorkMesh<Real>* mesh,
             FuseVertices<Real>* vertices, EdgeCosts<Real>* edge_costs);

  // Looks for a place where v and its candidate may become one, and at most so many tetrahedra go.
  // Changes nothing of the mesh. If nothing is refused, the rest is about that fusion, until the
  // next call or until the mesh changes.
  std::optional<FuseRefusal> plan(VertexId v, VertexId partner, std::uint64_t most_deleted);

  const Joining<Real>& joining() const { return joining_; }
  // Their quadrics, where both move.
  const MergedQuadric& merged() const { return merged_; }
  // The vertex that stays: a fixed one, else the first of the two.
  VertexId kept() const { return kept_; }
  // Of the vertex that they become; a fixed one keeps what it has.
  std::span<const double> values() const { return values_.values(); }
  Interpolation interpolation() const;
  // What is known of the error when they are one, if the candidate costs so much.
  double error(float cost) const;

  // The two become one: to be called right before the mesh changes ...
  void apply();
  // ... and afterwards.
  void note_fused() { cavity_.note_fused(kept_); }
  // When no more pairs come, and before what is deleted is dropped.
  void finish() { values_.finish(); }

  // Of a vertex inside of the mesh that was fused to its place: are there better values() for it?
  bool may_refit() const { return values_.may_refit(); }
  bool refit(VertexId v) { return values_.refit(v, vertices_->ball(v)); }
  // When it has these: a better place for it, with its values(). What it takes to move it has been
  // done then, but for the mesh itself; note_fused() is to follow.
  std::optional<Vec3<Real>> refit_position(VertexId v);

  // From now on all places are tried, however seldom anything comes of some.
  void be_thorough() { thorough_ = true; }

 private:
  using Verdict = std::optional<FuseRefusal>;  // nothing: it may be
  Verdict find_position();
  Verdict find_position_on_sheet();
  Verdict ask(const Vec3<Real>& position);
  Verdict judge();
  float weight() const;
  float most_elsewhere() const;
  std::optional<Vec3<Real>> push(Reject reason, float most) const;
  Verdict slide(FuseRefusal refusal, float most);
  bool sliding_pays();

  const FuseLimits* limits_ = nullptr;
  WorkMesh<Real>* mesh_ = nullptr;
  FuseVertices<Real>* vertices_ = nullptr;
  EdgeCosts<Real>* edge_costs_ = nullptr;
  FuseCavity<Real> cavity_;
  FuseValues<Real> values_;
  SheetFusion<Real> sheet_fusion_;
  EdgeLinks links_;
  BoundaryTriangles triangles_;

  bool thorough_ = false;
  // Positions that slide() tried and was content with, and times that it did not try.
  std::uint64_t slides_ = 0, slid_ = 0, not_slid_ = 0;

  // The pair in hand; its lists are of use when the cavity has been found to be allowed.
  Joining<Real> joining_;
  MergedQuadric merged_;  // where both move
  VertexId kept_ = kNoVertex;
};

extern template class FusePlanner<float>;
extern template class FusePlanner<double>;

}  // namespace tetfusion
