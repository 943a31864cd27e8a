// Fuse: neighbouring vertices become one, the cheapest first, where the fields change least. Each
// fusion is tested as a TetFuse is: every affected tetrahedron keeps positive volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "kernel/fuse/fuse_candidates.h"
#include "kernel/fuse/fuse_limits.h"
#include "kernel/fuse/fuse_planner.h"
#include "kernel/fuse/fuse_vertices.h"
#include "kernel/fusion_notes.h"
#include "kernel/fusions.h"
#include "kernel/quadrics/cost_queue.h"
#include "kernel/quadrics/edge_costs.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Works on a mesh or a chunk of one. Keeps its scratch memory. Not thread-safe; different objects
// are independent.
template <class Real>
class FuseRound {
 public:
  // Fuses what the limits allow, in the order of the costs: to within a twelfth where fusions are
  // near each other, else to within an octave, but that a vertex that waits for its turn does not
  // come earlier when a cheaper one turns up (about one in ten). Then compacts the mesh: ids are
  // stale afterwards, their order is kept. Carried columns follow; those that steer get the values
  // that the quadrics say are best. In the end, where a bound at points has refused something, new
  // vertices inside get better places and values, as far as the bounds let them. A pure function of
  // the mesh and the limits. `log` may be null; each fusion is appended to it.
  //
  // Preconditions: as for GreedyPass::run(), and the mesh has quadrics. With a log integrals are
  // not kept.
  FuseStatistics run(const FuseLimits& limits, std::span<const SteeringField> fields,
                     WorkMesh<Real>* mesh, FusionLog* log = nullptr);

  // From here on run() calls this before it begins, and every few vertices: with how many
  // tetrahedra have gone since the last call. What it throws ends the run, and the mesh is of no
  // use then.
  void watch(std::function<void(std::uint64_t gone)> watcher) { watcher_ = std::move(watcher); }

  // Finds out the costs alone.
  FuseStatistics look(const FuseLimits& limits, std::span<const SteeringField> fields,
                      WorkMesh<Real>* mesh);

 private:
  using State = typename FuseVertices<Real>::State;
  using Edges = typename FuseCandidates<Real>::Edges;

  void begin(const FuseLimits& limits, std::span<const SteeringField> fields, WorkMesh<Real>* mesh);
  void add_gradient_variances();
  void finish(FuseStatistics* statistics);
  Reject look_back(VertexId v, float* least, float* failed);

  // Whose turn it is.
  void work();
  void work_on(std::size_t block, std::size_t begin, std::size_t end);
  void prefetch_ahead(VertexId next) const;
  void tell_watcher();
  void visit(VertexId v);
  bool try_next(VertexId v, const FuseCandidate& candidate);
  void note_failure(VertexId v, Reject reason);
  bool quota_is_met() const { return limits_->quota < removed_ + kSmallestFusion; }
  bool wait(VertexId v, float cost);
  bool ask_again(std::size_t block, Edges edges);
  bool begin_again();

  // The fusion that is planned.
  void fuse(float cost);
  void note(VertexId kept, VertexId gone);
  float error_above(float cost) const;
  void merge_quadrics();
  void move_tets(VertexId kept, VertexId gone);
  void carry_rows(VertexId kept);

  void refit();
  void take_refitted(VertexId v, const Vec3<Real>& position);
  void compact();

  const FuseLimits* limits_ = nullptr;
  float threshold_ = 0;  // of these, as costs are
  std::span<const SteeringField> fields_;
  WorkMesh<Real>* mesh_ = nullptr;
  bool interpolates_ = false;  // there are point columns that do not steer

  FuseVertices<Real> vertices_;
  EdgeCosts<Real> edge_costs_;
  FuseCandidates<Real> candidates_;
  FusePlanner<Real> planner_;

  CostQueue queue_;
  std::size_t bin_ = 0;                     // whose turn it is
  std::vector<Vector<VertexId>> failures_;  // to be asked again, of each block
  std::uint64_t removed_ = 0, fused_ = 0;
  std::uint64_t deviated_ = 0;  // fusions that a bound refused
  Vector<VertexId> refitted_;
  Vector<float> quadric_;  // of one of them
  std::function<void(std::uint64_t)> watcher_;
  std::uint64_t told_ = 0;  // of those removed
  std::uint32_t visits_ = 0;

  Vector<Interpolation> interpolations_;
  FusionNotes<Real> notes_;
};

extern template class FuseRound<float>;
extern template class FuseRound<double>;

}  // namespace tetfusion
