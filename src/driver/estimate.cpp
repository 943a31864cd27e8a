#include "driver/estimate.h"
#include "driver/arrays/weights.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/blocks.h"
#include "base/resources.h"
#include "driver/import/import.h"
#include "driver/remainder.h"
#include "driver/request/stages.h"
#include "driver/rounds/original_values.h"
#include "driver/rounds/round_plan.h"
#include "driver/rounds/rounds.h"
#include "driver/run.h"
#include "driver/run_setup.h"
#include "mesh/inspection/boundary_sample.h"
#include "partition/vertex_chunks.h"

namespace tetfusion {

namespace {

// What loading chunks and cutting the mesh anew adds to the work on them: a quarter to a third
// measured.
constexpr double kCutting = 1.3;

template <class Real>
class Trial {
 public:
  Trial(const Run& run, Steering* steering, std::uint64_t sample_tets)
      : run_(run),
        steering_(steering),
        behaviour_(run.request.behaviour),
        planner_(behaviour_, run.input.description().point_type,
                 region_columns(run.input.carried, run.input.regions), run.input.weights),
        sample_tets_(sample_tets),
        boundary_(run.input.stream->points()),
        scratch_(memory_scratch()) {}

  RunEstimate run(double start);

 private:
  void import();
  void look_at_marks();
  void limit_errors();
  void fit_values(const OriginalValues<Real>& original);
  void reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds);
  std::optional<std::uint64_t> goal();
  double share_gone(const std::optional<Remainder<Real>>& remainder) const;
  double seconds_for_all(double reading, double assembling, double rounds) const;

  // How many times the vertices of the sample that may go the mesh has.
  double scale() const { return free_ > 0 ? inside_ / free_ : 0; }
  MacroLod<Real>& mesh() { return input_.mesh; }

  const Run& run_;
  Steering* steering_;
  const BehaviourOptions& behaviour_;
  RoundPlanner planner_;
  const std::uint64_t sample_tets_;
  BoundarySample boundary_;
  std::unique_ptr<Scratch> scratch_;
  PhaseClock clock_;
  ImportedMesh<Real> input_;
  std::vector<SteeringField> fields_;
  RoundsState state_;
  RunEstimate out_;
  double free_ = 0;    // vertices of the sample that may go
  double inside_ = 0;  // of the mesh, about
};

template <class Real>
RunEstimate Trial<Real>::run(double start) {
  import();
  const double assembling = clock_.seconds().at("assemble");
  const double reading = wall_seconds() - start - assembling;
  out_.tets = boundary_.tets();
  out_.sample_tets = mesh().tets;
  out_.boundary_share = boundary_.boundary_share();
  look_at_marks();
  limit_errors();
  out_.is_rough = surfaces_move(behaviour_) && !out_.is_whole();
  std::optional<Remainder<Real>> remainder;
  if (out_.is_rough) remainder.emplace(*mesh().whole);

  const auto layout = run_layout<Real>(behaviour_, run_.input.carried, steering_->width());
  Rounds<Real> rounds(layout, 1, run_.place.budget(), scratch_.get());
  state_.chunk_tets = behaviour_.chunk_tets;
  state_.weights =
      scale_weights(behaviour_.weight, run_.input.description(), *run_.input.stream, run_.context);
  OriginalValues<Real> original(
      scratch_.get(), layout,
      columns_to_fit(run_.request, run_.input.carried, run_.input.steering, run_.input.regions),
      surfaces_move(behaviour_));
  rounds.put_values_aside(&original);
  const double begin = wall_seconds();
  reach(goal(), &rounds);
  fit_values(original);
  out_.seconds = seconds_for_all(reading, assembling, wall_seconds() - begin);
  if (out_.goal) {
    state_.begin_stage();
    reach(std::nullopt, &rounds);
  }
  out_.sample_seconds = wall_seconds() - begin;
  out_.reduction = std::min(share_gone(remainder), 1 - 1 / static_cast<double>(out_.tets));
  return out_;
}

template <class Real>
double Trial<Real>::share_gone(const std::optional<Remainder<Real>>& remainder) const {
  const auto tets = static_cast<double>(out_.tets);
  const WorkMesh<Real>& left = *input_.mesh.whole;
  if (!remainder) return static_cast<double>(out_.sample_tets - left.tets.size()) * scale() / tets;
  const double boundary = static_cast<double>(boundary_.used_points()) * boundary_.boundary_share();
  return 1 - remainder->of_mesh(left, tets, boundary) / tets;
}

template <class Real>
void Trial<Real>::import() {
  const RunInput& in = run_.input;
  ImportSettings settings = import_settings(behaviour_, in.carried, in.regions, steering_->width());
  settings.chunk_tets =
      std::max(sample_tets_, block_count(in.stream->cells(), VertexChunks::kMaxChunks));
  settings.sample = &boundary_;
  settings.interest = &in.interest;
  input_ = import_mesh<Real>({*in.stream, in.carried, steering_}, settings, {},
                             {run_.context, &clock_, run_.place.budget(), scratch_.get()});
  clock_.end();
  fields_ = fields_of(*steering_, in.carried);
}

template <class Real>
void Trial<Real>::look_at_marks() {
  // Where surfaces move their vertices may go like others.
  const int stays = surfaces_move(behaviour_) ? 0 : kOnBoundary;
  double own = 0;
  for (const std::uint8_t marks : mesh().whole->marks) {
    if ((marks & (kOnInterface | stays)) != 0) continue;
    ++own;
    if ((marks & kLocked) == 0) ++free_;
  }
  if (out_.is_whole() || own == 0) {
    inside_ = free_;
    return;
  }
  const double share = stays != 0 ? 1 - out_.boundary_share : 1;
  inside_ = static_cast<double>(boundary_.used_points()) * share * free_ / own;
}

template <class Real>
void Trial<Real>::limit_errors() {
  planner_.limit_errors(error_limits(behaviour_, tolerances_of(fields_)));
}

// The sample's part of what has to go; its free vertices have to do with less.
template <class Real>
std::optional<std::uint64_t> Trial<Real>::goal() {
  const auto all = plan_stages(run_.request, out_.tets).back().tets;
  if (!all) return std::nullopt;
  const auto to_go = static_cast<double>(out_.tets - std::min(out_.tets, *all));
  out_.goal = to_go / static_cast<double>(out_.tets);
  const double part = scale() > 0 ? to_go / scale() : 0;
  const auto tets = static_cast<double>(out_.sample_tets);
  return static_cast<std::uint64_t>(std::max(1.0, std::ceil(tets - part)));
}

template <class Real>
void Trial<Real>::reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds) {
  while ((!goal || mesh().tets > *goal) && state_.end == StageEnd::kOpen) {
    run_.context.report("trying", 0.6);
    const RoundPlan plan = planner_.plan(input_.box, mesh().tets, goal, state_);
    const RoundStatistics round = rounds->run(plan.settings, fields_, run_.context, &mesh());
    planner_.note(plan, round, &state_);
  }
}

// For the time that it takes: whatever else is tried goes on without.
template <class Real>
void Trial<Real>::fit_values(const OriginalValues<Real>& original) {
  if (original.chunks() == 0 || original.columns().empty()) return;  // no round, or nothing to fit
  WorkMesh<Real> fitted = *mesh().whole;
  FitTools<Real> tools;
  FittedValues<Real>(original, mesh(), move_limits(behaviour_, original.columns(), fields_), 1,
                     scratch_.get())
      .fit(0, &tools, &fitted);
}

// A thread has a chunk at a time: with few chunks some threads have none in the end.
template <class Real>
double Trial<Real>::seconds_for_all(double reading, double assembling, double rounds) const {
  const auto chunks = static_cast<double>(
      std::max<std::uint64_t>(1, block_count(out_.tets, behaviour_.chunk_tets)));
  const double turns = std::ceil(chunks / thread_count()) / chunks;
  const double times = static_cast<double>(out_.tets) / static_cast<double>(out_.sample_tets);
  return reading + times * (assembling + (chunks > 1 ? kCutting : 1) * rounds) * turns;
}

}  // namespace

double RunEstimate::low_reduction() const {
  return is_rough ? std::max(0.0, 1 - kRoughFactor * (1 - reduction)) : reduction;
}

std::optional<bool> RunEstimate::reaches_goal() const {
  if (!goal) return std::nullopt;
  if (*goal <= low_reduction()) return true;
  return is_rough ? std::nullopt : std::optional(false);
}

RunEstimate estimate_run(const Run& run, Steering* steering, std::uint64_t sample_tets,
                         double start) {
  return run.input.description().point_type == ValueType::kFloat32
             ? Trial<float>(run, steering, sample_tets).run(start)
             : Trial<double>(run, steering, sample_tets).run(start);
}

}  // namespace tetfusion
