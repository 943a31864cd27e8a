#include "driver/estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/resources.h"
#include "driver/import.h"
#include "driver/round_plan.h"
#include "driver/rounds.h"
#include "driver/run_setup.h"
#include "driver/stages.h"
#include "mesh/blocks.h"
#include "mesh/boundary_sample.h"
#include "partition/vertex_chunks.h"

namespace tetfusion {

namespace {

// What loading chunks and cutting the mesh anew adds to the work on them: a quarter to a third
// measured.
constexpr double kCutting = 1.3;

template <class Real>
class Trial {
 public:
  Trial(const EstimateRequest& request, const RunContext& context, MemoryBudget* budget)
      : request_(request),
        behaviour_(request.request.behaviour),
        context_(context),
        budget_(budget),
        planner_(behaviour_),
        boundary_(request.stream.points()),
        scratch_(memory_scratch()) {}

  RunEstimate run();

 private:
  void import(const CarriedArrays& carried);
  void look_at_marks();
  void limit_errors();
  void reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds);
  std::optional<std::uint64_t> goal();
  double seconds_for_all(double reading, double assembling, double rounds) const;

  // How many times the vertices of the sample that may go the mesh has.
  double scale() const { return free_ > 0 ? inside_ / free_ : 0; }
  MacroLod<Real>& mesh() { return input_.mesh; }

  const EstimateRequest& request_;
  const BehaviourOptions& behaviour_;
  const RunContext& context_;
  MemoryBudget* budget_;
  RoundPlanner planner_;
  BoundarySample boundary_;
  std::unique_ptr<Scratch> scratch_;
  PhaseClock clock_;
  ImportedMesh<Real> input_;
  std::vector<SteeringField> fields_;
  std::vector<std::uint32_t> regions_;  // columns whose interfaces move
  WeightColumn weights_;
  RoundsState state_;
  RunEstimate out_;
  double free_ = 0;    // vertices of the sample that may go
  double inside_ = 0;  // of the mesh, about
};

template <class Real>
RunEstimate Trial<Real>::run() {
  const CarriedArrays carried(request_.description);
  import(carried);
  const double assembling = clock_.seconds().at("assemble");
  const double reading = wall_seconds() - request_.start - assembling;
  out_.tets = boundary_.tets();
  out_.sample_tets = mesh().tets;
  out_.boundary_share = boundary_.boundary_share();
  look_at_marks();
  limit_errors();
  weights_ = weight_column(behaviour_.weight, request_.description, carried);
  if (surfaces_move(behaviour_)) regions_ = region_columns(carried, request_.regions);

  const auto layout = run_layout<Real>(behaviour_, carried, request_.steering.width());
  Rounds<Real> rounds(layout, 1, budget_, scratch_.get());
  state_.chunk_tets = behaviour_.chunk_tets;
  const double begin = wall_seconds();
  reach(goal(), &rounds);
  out_.seconds = seconds_for_all(reading, assembling, wall_seconds() - begin);
  if (out_.goal) {
    state_.end = StageEnd::kOpen;
    state_.spread = 1;
    reach(std::nullopt, &rounds);
  }
  out_.sample_seconds = wall_seconds() - begin;
  const auto gone = static_cast<double>(out_.sample_tets - mesh().tets);
  const double share = gone * scale() / static_cast<double>(out_.tets);
  out_.reduction = std::min(share, 1 - 1 / static_cast<double>(out_.tets));
  return out_;
}

template <class Real>
void Trial<Real>::import(const CarriedArrays& carried) {
  const Steering& steering = request_.steering;
  fields_ = fields_of(steering, carried);
  ImportSettings settings =
      import_settings(behaviour_, carried, request_.regions, steering.width());
  settings.chunk_tets = std::max(request_.sample_tets,
                                 block_count(request_.stream.cells(), VertexChunks::kMaxChunks));
  settings.sample = &boundary_;
  settings.interest = &request_.interest;
  input_ = import_mesh<Real>(request_.stream, carried, steering, settings, {}, context_, &clock_,
                             budget_, scratch_.get());
  clock_.end();
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
  const ErrorLimits limits = error_limits(behaviour_, fields_);
  if (limits.at_points && boundary_.used_points() < request_.stream.points()) {
    relate_to_used_points(input_.steering_box, limits.max_error, &fields_);
  }
  planner_.limit_errors(error_limits(behaviour_, fields_));
}

// The sample's part of what has to go; its free vertices have to do with less.
template <class Real>
std::optional<std::uint64_t> Trial<Real>::goal() {
  const auto all = plan_stages(request_.request, out_.tets).back().tets;
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
    context_.report("trying", 0.6);
    RoundPlan plan = planner_.plan(input_.box, mesh().tets, goal, state_);
    plan.settings.fuse.regions = regions_;
    plan.settings.fuse.weights = weights_;
    const RoundStatistics round =
        rounds->run(plan.settings, plan.limits, fields_, context_, &mesh());
    planner_.note(plan, round, &state_);
  }
}

// A thread has a chunk at a time: with few chunks some threads have none in the end.
template <class Real>
double Trial<Real>::seconds_for_all(double reading, double assembling, double rounds) const {
  const auto chunks = static_cast<double>(
      std::max<std::uint64_t>(1, block_count(out_.tets, behaviour_.chunk_tets)));
  const double turns = std::ceil(chunks / request_.threads) / chunks;
  const double times = static_cast<double>(out_.tets) / static_cast<double>(out_.sample_tets);
  return reading + times * (assembling + (chunks > 1 ? kCutting : 1) * rounds) * turns;
}

}  // namespace

RunEstimate estimate_run(const EstimateRequest& request, const RunContext& context,
                         MemoryBudget* budget) {
  return request.description.point_type == ValueType::kFloat32
             ? Trial<float>(request, context, budget).run()
             : Trial<double>(request, context, budget).run();
}

}  // namespace tetfusion
