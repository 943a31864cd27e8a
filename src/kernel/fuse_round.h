// Fuse: neighbouring vertices become one, the cheapest first, where the fields change least. Each
// fusion is tested as a TetFuse is: every affected tetrahedron keeps positive volume.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "kernel/cost_queue.h"
#include "kernel/costs.h"
#include "kernel/criteria.h"
#include "kernel/edge_costs.h"
#include "kernel/field_integrals.h"
#include "kernel/fuse_cavity.h"
#include "kernel/fusion_notes.h"
#include "kernel/fusions.h"
#include "kernel/live_balls.h"
#include "kernel/paper_bounds.h"
#include "kernel/point_errors.h"
#include "kernel/sheet_fusion.h"
#include "kernel/sheets.h"
#include "kernel/vertex_quadrics.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

enum class Method : std::uint8_t {
  kTetFuse,  // the paper's: the four vertices of a tetrahedron become one
  kFuse,     // neighbours become one, cheapest first
};

// A column of one finite value >= 0 a row: errors count so many times as much there, and fusions
// cost its square. Of cells: at a vertex the largest one round it counts. kNoColumn: all count
// alike.
struct WeightColumn {
  std::uint32_t column = kNoColumn;
  bool of_cells = false;
};

struct FuseLimits {
  // No fusion costs more: the mean of the squared deviations, as shares of the fields' ranges, of
  // the fused vertex's fields from those of the original mesh that it stands for. Nor are the new
  // fields off by more than the root of an eighth of it at a vertex that goes, unless in the mean
  // the squares have been an eighth of that or more, in this round.
  double threshold = std::numeric_limits<double>::infinity();
  // No affected tetrahedron has a lower mean ratio, unless one of the cavity had; in [0, 1).
  double min_quality = 0;
  // No steering field deviates by more at a point of the original mesh, as a share of its range,
  // unless it has a tolerance of its own.
  double max_error = std::numeric_limits<double>::infinity();
  // Nor does one that has a bound deviate by more than this, in this round.
  double error_now = std::numeric_limits<double>::infinity();
  PaperLimits paper;            // of single fusions; stretch is against the start of the round
  bool keep_integrals = false;  // of all floating-point fields (field_integrals.h)
  // Added to the quadrics before the round begins, in squared shares of ranges a squared unit. For
  // a mesh in which nothing has fused yet.
  double gradient_variance = 0;
  double unit = 1;  // of lengths, as in begin_quadrics(): about 1 / the mesh's diagonal
  // All places are tried, however seldom anything comes of some. For a mesh that hardly shrinks.
  bool thorough = false;
  // At most so many tetrahedra may go.
  std::uint64_t quota = std::numeric_limits<std::uint64_t>::max();

  // So far, in the unit, may sheets (sheets.h) move in all; negative: they stay as they are. The
  // mesh has deviations if they may.
  double max_deviation = -1;
  // So far has one moved at most when the round begins.
  double deviation_before = 0;
  double sheet_weight = 0;             // as in EdgeCosts::begin()
  std::vector<std::uint32_t> regions;  // cell columns: sheets lie where their values differ
  WeightColumn weights;
  // Ways the boundary looks at the beginning of the round: no part of it rises where another part
  // that faces it may be in reach, unless all that are there are this mesh's own, and lie
  // elsewhere. Null: there is none.
  const FacingGrid* facing = nullptr;
  // To be filled in; and whether the boundary's marks are known of vertices on the interface.
  FacingGrid* facing_after = nullptr;
  bool marks_are_known = true;
  // Sheets that may move do not in this round, as nobody knows yet which ways the boundary looks.
  bool sheets_rest = false;
  bool sheets_move() const { return max_deviation >= 0; }
};

struct FuseStatistics {
  PassStatistics pass;    // `rejected` counts the vertices that are left, by why
  CostHistogram costs{};  // of those vertices that may fuse, as far as is known
  float deviation = 0;    // the largest of a vertex that is left, in the unit
};

// Works on a mesh or a chunk of one. Keeps its scratch memory. Not thread-safe; different objects
// are independent.
template <class Real>
class FuseRound {
 public:
  // Fuses what the limits allow, in the order of the costs: to within a twelfth where fusions are
  // near each other, else to within an octave, but that a vertex that waits for its turn does not
  // come earlier when a cheaper one turns up (about one in ten). Then compacts the mesh: ids are
  // stale afterwards, their order is kept. Carried columns follow; those that steer get the values
  // that the quadrics say are best. A pure function of the mesh and the limits. `log` may be null;
  // each fusion is appended to it.
  //
  // Preconditions: as for GreedyPass::run(), and the mesh has quadrics. With a log integrals are
  // not kept.
  FuseStatistics run(const FuseLimits& limits, std::span<const SteeringField> fields,
                     WorkMesh<Real>* mesh, FusionLog* log = nullptr);

  // Finds out the costs alone.
  FuseStatistics look(const FuseLimits& limits, std::span<const SteeringField> fields,
                      WorkMesh<Real>* mesh);

 private:
  static constexpr std::size_t kCandidates = 12;
  static constexpr TetId kNoTet = ~TetId{0};
  struct Candidate {
    float cost;
    VertexId partner;
    TetId refused_by;  // what the best position was refused for
  };
  static constexpr Candidate kNoCandidate{std::numeric_limits<float>::infinity(), kNoVertex,
                                          kNoTet};
  using Candidates = std::array<Candidate, kCandidates>;  // ascending by cost
  enum Kind : std::uint8_t {
    kFree,     // inside: may be fused
    kOnSheet,  // may be fused along a sheet; others may come to it
    kOnLine,   // the same, along a line of a sheet
    kTarget,   // stays where it is; others may come to it
    kOut,      // neither
  };

  // Of a vertex, in one place: whoever looks at a neighbour wants most of it. Events have numbers,
  // ascending from 1.
  struct State {
    std::uint32_t stamp = 0;    // the last search for neighbours that has found it
    std::uint32_t changed = 1;  // it got its quadric
    std::uint32_t judged = 0;   // its candidates were chosen
    std::uint32_t failed = 0;   // one of them could not be fused with
    std::uint32_t moved = 1;    // its ball changed
    Kind kind = kOut;
    std::uint8_t reason = 0;  // why the last fusion of it failed
    std::uint8_t place = 0;   // in its candidates: those before are used up
    bool listed = false;      // among the failures
  };

  void begin(const FuseLimits& limits, std::span<const SteeringField> fields, WorkMesh<Real>* mesh);
  Kind kind_of(VertexId v);
  bool may_move(VertexId v) const { return state_[v].kind < kTarget; }
  bool is_on_sheet(VertexId v) const {
    return state_[v].kind == kOnSheet || state_[v].kind == kOnLine;
  }
  Along along(VertexId v) const { return state_[v].kind == kOnLine ? Along::kLine : Along::kSheet; }
  void finish(FuseStatistics* statistics);
  Reject look_back(VertexId v, float* least, float* failed);

  enum class Edges : std::uint8_t { kOwn, kAll };  // of a vertex: to be judged by it, or any

  // Whose turn it is.
  void work();
  void work_on(std::size_t block, std::size_t begin, std::size_t end);
  void ask_ahead(VertexId next) const;
  void visit(VertexId v);
  const Candidate* next_candidate(VertexId v);
  bool is_refused(VertexId v, const Candidate& candidate) const;
  void note_reason(VertexId v);
  // An edge inside has three tetrahedra or more.
  bool quota_is_met() const { return limits_->quota < removed_ + 3; }
  bool wait(VertexId v, float cost);
  bool ask_again(Edges edges);

  // With whom.
  bool knows_candidates(VertexId v) const { return state_[v].judged > state_[v].changed; }
  void begin_weights();
  void add_gradient_variances();
  // What a fusion of these costs, as a multiple of what it does.
  float weight_of(VertexId v, VertexId partner) const;
  float threshold_for(VertexId v, VertexId partner) const {
    return static_cast<float>(limits_->threshold) / weight_of(v, partner);
  }
  float& known_cost(VertexId v) { return mesh_->quadrics[(v + 1) * mesh_->quadric_width - 1]; }

  // The same (fuse_partners.cpp).
  void judge(VertexId v, Edges edges = Edges::kOwn);
  void find_partners(VertexId v);
  std::size_t choose_partners(VertexId v, Edges edges);

  // One fusion.
  bool fuse(VertexId v, const Candidate& candidate);
  float error_of(VertexId v, const Candidate& candidate) const;
  bool plan(VertexId v, VertexId partner);
  bool push(VertexId v, VertexId partner, float most);
  void note_refusal();
  bool slide(VertexId v, VertexId partner, float most);
  bool sliding_pays();
  bool allows(VertexId v, VertexId partner);
  bool loses_too_much(VertexId v, VertexId partner);
  double best_at(VertexId v, const Offset& u, std::size_t k) const;
  void raise_cost(VertexId v);
  // May the values speak against a fusion?
  bool judges_values() const { return errors_.bounds() || paper_.any() || integrals_.stay(); }
  std::optional<Reject> judge_values(VertexId v, VertexId partner);
  void apply(VertexId v, VertexId partner, VertexId kept, float error);
  void merge_quadrics(VertexId v, VertexId kept);
  void choose_values(VertexId v, VertexId partner);
  void move_tets(VertexId kept, VertexId gone);
  void note(VertexId kept, VertexId gone);
  void carry_rows(VertexId kept);

  // The same on sheets (fuse_sheets.cpp).
  void begin_sheets();
  bool is_on_one(VertexId v) const {
    return (mesh_->marks[v] & kOnBoundary) != 0 || sheets_.is_between_regions(v);
  }
  Kind kind_on_sheet(VertexId v);
  void find_partners_on_sheet(VertexId v);
  bool plan_on_sheet(VertexId v, VertexId partner);

  void compact();
  std::span<const std::uint32_t> ball(VertexId v) {
    return balls_.of(v, mesh_->incidence[v], mesh_->tets);
  }

  const FuseLimits* limits_ = nullptr;
  std::span<const SteeringField> fields_;
  WorkMesh<Real>* mesh_ = nullptr;
  std::size_t width_ = 0;
  bool interpolates_ = false;  // there are point columns that do not steer

  LiveBalls balls_;
  Sheets<Real> sheets_;
  SheetFusion<Real> sheet_fusion_;
  BoundaryTriangles triangles_;
  SheetFan fan_;
  EdgeCosts<Real> edge_costs_;
  Vector<State> state_;
  Vector<float> weights_;  // of errors; none if all count alike
  Vector<Candidates> candidates_;

  // Of the vertex in hand: its neighbours, then those that were chosen (choose_partners()), and
  // what that takes; what fusions with them cost, and their places in the order of costs.
  std::uint32_t stamped_ = 0;
  Vector<VertexId> partners_, chosen_, fixed_ones_;
  Vector<float> costs_;
  Vector<std::int32_t> places_;

  std::uint32_t now_ = 0;  // the last event

  CostQueue queue_;
  std::size_t bin_ = 0;        // whose turn it is
  Vector<VertexId> failures_;  // to be asked again
  std::uint64_t removed_ = 0, fused_ = 0;
  double losses_ = 0;  // of all that were fused
  // Positions that slide() tried and was content with, and times that it did not try.
  std::uint64_t slides_ = 0, slid_ = 0, not_slid_ = 0;
  bool turns_over_ = false;  // all have had theirs in this round

  // The fusion in hand.
  std::vector<double> values_, least_, most_;  // of the new vertex; the cavity's, now
  Interpolation interpolation_;
  Vec3<Real> position_{};
  bool fixed_ = false;  // the partner stays where it is
  double loss_ = 0;     // what the errors at the two points cost, at most the threshold
  float dear_ = 0;      // if it was refused for that: what it should cost
  Reject reject_{};
  TetId refused_by_ = kNoTet;  // Candidate::refused_by
  FuseCavity<Real> cavity_;
  PaperBounds<Real> paper_;
  FieldIntegrals<Real> integrals_;
  PointErrors<Real> errors_;

  Vector<Interpolation> interpolations_;
  FusionNotes<Real> notes_;
};

extern template class FuseRound<float>;
extern template class FuseRound<double>;

}  // namespace tetfusion
