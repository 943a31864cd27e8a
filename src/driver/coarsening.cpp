#include "driver/coarsening.h"
#include "driver/arrays/weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/numbers.h"
#include "base/resources.h"
#include "driver/arrays/notices.h"
#include "driver/export/progressive.h"
#include "driver/import/assemble.h"
#include "driver/request/error_limits.h"
#include "driver/run_setup.h"

namespace tetfusion {

template <class Real>
Coarsening<Real>::Coarsening(Run* run)
    : run_(*run),
      options_(run->request.behaviour),
      planner_(options_, run->input.description().point_type,
               region_columns(run->input.carried, run->input.regions), run->input.weights) {}

// Makes what rounds need, and what is put aside on their way.
template <class Real>
void Coarsening<Real>::begin(std::uint32_t steering_width) {
  const RunInput& in = run_.input;
  Scratch* scratch = run_.place.scratch();
  layout_ = run_layout<Real>(options_, in.carried, steering_width);
  WorkMesh<Real> rows = layout_;
  if (keeps_numbers(run_.request)) rows.cell_columns.push_back(number_column());
  rounds_ = std::make_unique<Rounds<Real>>(rows, thread_count(), run_.place.budget(), scratch);
  rounds_->watch([this](std::uint64_t tets) {
    run_.context.check();
    // The import says itself how far it is; and without a goal nobody knows how far a round goes.
    if (is_importing_ || !stages_.back().tets) return;
    const double share = share_done(tets);
    const int percent = static_cast<int>(100 * share);
    if (told_percent_.exchange(percent, std::memory_order_relaxed) == percent) return;
    run_.context.report("fusing", share);
  });
  if (run_.keeps_logs()) {
    logs_ = std::make_unique<FusionLogs>(scratch, log_bytes_per_tet(in.description()));
    rounds_->keep_logs(logs_.get());
  }
  ColumnsToFit columns = columns_to_fit(run_.request, in.carried, in.steering, in.regions);
  if (!columns.empty()) {
    state_.values = std::make_unique<OriginalValues<Real>>(scratch, layout_, std::move(columns),
                                                           surfaces_move(options_));
    rounds_->put_values_aside(state_.values.get());
  }
}

template <class Real>
void Coarsening<Real>::resume(Checkpoint left) {
  load(left.state, &state_);
  state_.mesh.pieces = std::move(left.pieces);
  run_.context.say(fmt::format("going on after {}, with {} left",
                               format_count(state_.rounds.size(), "round"),
                               format_count(state_.mesh.tets, "tetrahedron", "tetrahedra")));
  begin(state_.steering_width);
  if (logs_) logs_->resume(state_.log_slices, &left);
  if (state_.values) state_.values->resume(state_.kept_values, &left);
  plan_output(state_.input.facts.tets);
  planner_.limit_errors(error_limits(options_, tolerances_of(state_.fields)));
  run_.input.stream.reset();
}

template <class Real>
void Coarsening<Real>::import() {
  RunInput& in = run_.input;
  Steering steering = read_steering(&run_);
  state_.weights = scale_weights(options_.weight, in.description(), *in.stream, run_.context);
  begin(steering.width());
  const auto take_fields = [&] {
    state_.fields = fields_of(steering, in.carried);
    planner_.limit_errors(error_limits(options_, tolerances_of(state_.fields)));
  };
  take_fields();
  state_.field_names = steering.names();
  state_.steering_width = steering.width();
  state_.chunk_tets = options_.chunk_tets;
  ImportSettings settings = import_settings(options_, in.carried, in.regions, steering.width());
  settings.interest = &in.interest;
  settings.keeps_numbers = keeps_numbers(run_.request);
  settings.excerpt =
      options_.method == Method::kFuse && options_.boundary_rule == BoundaryRule::kVertices;
  RoundPlan plan;
  is_importing_ = true;
  ImportedMesh<Real> imported = import_mesh<Real>(
      {*in.stream, in.carried, &steering}, settings, first_round(take_fields, &plan),
      {run_.context, &run_.clock, run_.place.budget(), run_.place.scratch()});
  is_importing_ = false;
  first_round_done_ = imported.first_round_done;
  state_.mesh = std::move(imported.mesh);
  state_.input = std::move(imported);
  say_what_was_found();
  plan_output(state_.input.facts.tets);
  if (first_round_done_) {
    const InterfaceTable marks = std::move(state_.mesh.interface);
    const RoundStatistics round = rounds_->end(&state_.mesh, marks);
    end_round(plan, round);
  } else {
    commit("import");
  }
  in.stream.reset();
  trim_memory();
}

// What is to be written of a mesh of so many tetrahedra.
template <class Real>
void Coarsening<Real>::plan_output(std::uint64_t tets) {
  run_.context.report_size(tets);
  input_tets_ = tets;
  check_levels(run_.request, tets);
  stages_ = plan_stages(run_.request, tets);
}

// Under the rule of boundary tetrahedra there is none, as chunks must know each other's boundary
// before they begin. `plan` is made when all is known that it depends on.
template <class Real>
FirstRound<Real> Coarsening<Real>::first_round(std::function<void()> scattered, RoundPlan* plan) {
  FirstRound<Real> first;
  first.scattered = std::move(scattered);
  if (options_.boundary_rule != BoundaryRule::kVertices) return first;
  first.look = [this](const Box& box, std::uint64_t tets, WorkMesh<Real>* excerpt) {
    look_at_excerpt(box, tets, excerpt);
  };
  first.begin = [this, plan](const Box& box, std::uint64_t tets, std::vector<std::uint64_t> shares,
                             const Vector<Vec3<Real>>& samples) {
    plan_output(tets);
    *plan = plan_round(box, tets, stages_.front().tets);
    rounds_->begin(plan->settings, state_.fields, {tets, std::move(shares), samples});
  };
  first.work = [this](std::uint32_t chunk, std::size_t worker, WorkMesh<Real>* mesh) {
    rounds_->work(chunk, worker, mesh);
  };
  first.drop = [this] { rounds_->drop(); };
  return first;
}

// Finds out about what fusions cost in all of the mesh. The excerpt has all tetrahedra of those of
// its points that are not between chunks.
template <class Real>
void Coarsening<Real>::look_at_excerpt(const Box& box, std::uint64_t tets,
                                       WorkMesh<Real>* excerpt) {
  std::uint64_t corners = 0;
  for (std::size_t v = 0; v < excerpt->vertex_count(); ++v) {
    if ((excerpt->marks[v] & kOnInterface) == 0) corners += excerpt->incidence[v];
  }
  if (corners == 0) return;
  const RoundPlan plan = plan_round(box, tets, std::nullopt);
  CostHistogram costs = rounds_->look(plan.settings, state_.fields, excerpt);
  const double times = 4 * static_cast<double>(tets) / static_cast<double>(corners);
  for (std::uint64_t& count : costs) {
    count = static_cast<std::uint64_t>(std::ceil(times * static_cast<double>(count)));
  }
  state_.costs = costs;
}

template <class Real>
void Coarsening<Real>::say_what_was_found() const {
  const RunInput& in = run_.input;
  say_what_is_odd(state_.input.facts, in.description(), options_.linearize, run_.context);
  if (state_.input.facts.differing_points > 0 &&
      limits_errors(options_, tolerances_of(state_.fields))) {
    say_whose_bounds(run_.context);
  }
  say_which_are_regions(in.description(), *in.stream, state_.input.facts.tets, in.regions,
                        options_.regions.has_value(), run_.context);
  const std::uint64_t uncounted = in.stream->merged_points() + in.stream->dropped_points();
  if (options_.original_ids && uncounted > 0) {
    run_.context.say(fmt::format(
        "{} leaves out {} that no cell uses, or that copies of others are: it counts the points "
        "of what 'tetfusion convert' makes of the input",
        kOriginalIds, format_count(uncounted, "point")));
  }
  if (surfaces_move(options_)) {
    say_which_may_be_node_sets(in.description(), *in.stream, in.steering, run_.context);
  }
  say_which_are_directions(in.description(), *in.stream, run_.context);
  if (!in.interest.empty() && state_.input.interesting_points == 0) {
    run_.context.say("no point of the mesh is in the region of interest (--roi): it keeps nothing");
  }
}

template <class Real>
bool Coarsening<Real>::reach(const std::optional<std::uint64_t>& goal) {
  MacroLod<Real>& mesh = state_.mesh;
  while (!goal || mesh.tets > *goal) {
    if (state_.end != StageEnd::kOpen) return state_.end == StageEnd::kGoal;
    run_.context.report("fusing", share_done());
    const RoundPlan plan = plan_round(state_.input.box, mesh.tets, goal);
    const RoundStatistics round = rounds_->run(plan.settings, state_.fields, run_.context, &mesh);
    end_round(plan, round);
  }
  return true;
}

template <class Real>
RoundPlan Coarsening<Real>::plan_round(const Box& box, std::uint64_t tets,
                                       const std::optional<std::uint64_t>& goal) const {
  RoundPlan plan = planner_.plan(box, tets, goal, state_);
  const auto& most = options_.give_up_rms;
  if (most && !plan.settings.look && plan.settings.fuse.threshold > *most * *most) {
    throw OutOfReach();
  }
  return plan;
}

// Notes what a round did, and keeps it.
template <class Real>
void Coarsening<Real>::end_round(const RoundPlan& plan, const RoundStatistics& round) {
  planner_.note(plan, round, &state_);
  trim_memory();
  commit(fmt::format("round-{}", plan.settings.number));
}

template <class Real>
void Coarsening<Real>::commit(const std::string& generation) {
  if (!run_.place.keeps_work() || state_.mesh.whole) return;
  if (logs_) state_.log_slices = logs_->keep();
  if (state_.values) state_.kept_values = state_.values->keep();
  run_.place.commit(generation, save(state_));
}

template <class Real>
void Coarsening<Real>::end_stage(const MeshSummary& output) {
  state_.outputs.push_back(output);
  state_.begin_stage();
}

template <class Real>
void Coarsening<Real>::pause() {
  rounds_->release_memory();
  trim_memory();
}

template <class Real>
void Coarsening<Real>::end_rounds() {
  rounds_.reset();
  run_.place.scratch()->drop_spares();
}

namespace {

// How much of a run is done when it has come from `first` tetrahedra to `tets`, in so many rounds.
// Without a goal nobody knows where they will end; most of what goes does so in the first ones.
double share_of_way(std::uint64_t first, std::uint64_t tets,
                    const std::optional<std::uint64_t>& goal, std::size_t rounds) {
  constexpr double kRoundsShare = 0.55;
  if (!goal)
    return kAssembledShare + kRoundsShare * (1 - std::pow(0.7, static_cast<double>(rounds)));
  const double wanted = static_cast<double>(first) - static_cast<double>(*goal);
  const double done =
      wanted > 0 ? (static_cast<double>(first) - static_cast<double>(tets)) / wanted : 1;
  return kAssembledShare + kRoundsShare * std::min(done, 1.0);
}

}  // namespace

template <class Real>
double Coarsening<Real>::share_done() const {
  return share_done(state_.mesh.tets);
}

template <class Real>
double Coarsening<Real>::share_done(std::uint64_t tets) const {
  const double share = share_of_way(input_tets_, tets, stages_.back().tets, state_.rounds.size());
  return first_round_done_ ? std::max(share, kAssembledWithWork) : share;
}

template class Coarsening<float>;
template class Coarsening<double>;

}  // namespace tetfusion
