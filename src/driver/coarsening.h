// A mesh on its way from the input to one goal after another: the import, or what an earlier run
// has left, and then round after round.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driver/checkpoint.h"
#include "driver/request/stages.h"
#include "driver/rounds/fusion_logs.h"
#include "driver/rounds/round_plan.h"
#include "driver/rounds/rounds.h"
#include "driver/run.h"

namespace tetfusion {

// After the import and after each round what is left is committed, where the run keeps its work.
template <class Real>
class Coarsening {
 public:
  // Nothing is read yet. The run, whose place is open, outlives this.
  explicit Coarsening(Run* run);

  // One of the two first. import() reads the input, says what is odd about it, and does the first
  // round on the way where that can be done (FirstRound); the input's stream is closed then.
  // resume() goes on from what an earlier run has committed. Throw Error; OutOfReach.
  void import();
  void resume(Checkpoint left);

  // Runs rounds until no more tetrahedra than the goal are left, or as near to it as can be (true),
  // or nothing fuses (false). Throws Error(kInterrupted); OutOfReach.
  bool reach(const std::optional<std::uint64_t>& goal);
  // That mesh is written: the next round belongs to another stage.
  void end_stage(const MeshSummary& output);
  // Something else needs the memory for a while: what rounds can make anew goes ...
  void pause();
  // ... and, as no round follows, all that only rounds need.
  void end_rounds();

  // What is to be written; the last stage's goal is that of the run.
  const std::vector<Stage>& stages() const { return stages_; }
  double share_done() const;  // of the run

  const RunState<Real>& state() const { return state_; }
  const WorkMesh<Real>& layout() const { return layout_; }  // of rows, but for cells' numbers
  FusionLogs* logs() const { return logs_.get(); }          // null where nobody wants them

 private:
  void begin(std::uint32_t steering_width);
  void plan_output(std::uint64_t tets);
  FirstRound<Real> first_round(std::function<void()> scattered, RoundPlan* plan);
  void look_at_excerpt(const Box& box, std::uint64_t tets, WorkMesh<Real>* excerpt);
  void say_what_was_found() const;
  RoundPlan plan_round(const Box& box, std::uint64_t tets,
                       const std::optional<std::uint64_t>& goal) const;
  void end_round(const RoundPlan& plan, const RoundStatistics& round);
  void commit(const std::string& generation);
  double share_done(std::uint64_t tets) const;  // with so many left

  Run& run_;
  const BehaviourOptions& options_;
  RoundPlanner planner_;
  WorkMesh<Real> layout_;
  std::uint64_t input_tets_ = 0;
  bool is_importing_ = false;
  bool first_round_done_ = false;     // by the import
  std::atomic<int> told_percent_{0};  // within rounds
  std::vector<Stage> stages_;
  RunState<Real> state_;
  std::unique_ptr<FusionLogs> logs_;
  std::unique_ptr<Rounds<Real>> rounds_;  // uses what is above
};

extern template class Coarsening<float>;
extern template class Coarsening<double>;

}  // namespace tetfusion
