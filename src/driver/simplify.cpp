#include "driver/simplify.h"

#include <fmt/format.h>

#include <filesystem>
#include <new>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "driver/arrays/regions.h"
#include "driver/coarsening.h"
#include "driver/export/export.h"
#include "driver/export/progressive.h"
#include "driver/promise.h"
#include "driver/request/stages.h"
#include "driver/run.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "driver/stage_output.h"
#include "io/store/scratch_folder.h"

namespace tetfusion {

namespace {

void describe_input(const Run& run, const InputFacts& facts, SimplifyReport* report) {
  report->input = {run.request.input, facts.points, facts.tets, facts.boundary_faces, facts.volume};
  report->facts = facts;
  const auto& point_arrays = run.input.description().point_data.arrays;
  const LargestDifference& largest = facts.largest_difference;
  if (largest.share > 0 && largest.array < point_arrays.size()) {
    report->differing_array = point_arrays[largest.array].name;
  }
  report->regions = names_of_cell_arrays(run.input.description(), run.input.regions);
  report->has_interest = !run.request.behaviour.interest.empty();
}

// They may be gone, and what is wanted of them now may not have been when they were written.
void check_earlier_levels(const std::vector<Stage>& stages, std::size_t written, const Run& run) {
  for (std::size_t i = 0; i < written; ++i) {
    std::error_code unknown;
    const auto is_there = [&](const std::string& path) {
      return std::filesystem::exists(path, unknown);
    };
    if (run.sink == nullptr && !is_there(stages[i].path)) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("{} was written by the run that was interrupted, and is not there "
                              "any more: remove {} and begin anew",
                              stages[i].path, scratch_folder(run.request)));
    }
    const std::string& map = stages[i].map;
    if (!map.empty() && !is_there(map)) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("{} was written by the run that was interrupted, and {} is not there: "
                      "give the --map of that run, or begin anew without --resume",
                      stages[i].path, map));
    }
  }
  if (written > 0 && run.request.verify) {
    run.context.say(
        "--verify looks at the levels that are written from here on, not at those that are there");
  }
}

// Of the folder of an earlier run, that this one does not go on from it.
void say_what_is_left(const Run& run) {
  const std::string folder = scratch_folder(run.request);
  std::error_code unknown;
  if (run.request.performance.resume) {
    run.context.say("there is nothing to go on with (--resume): the run begins anew");
  } else if (!run.place.on_disk() &&
             std::filesystem::exists(folder + "/" + kManifestName, unknown)) {
    run.context.say(
        fmt::format("{} holds the work of another run, for which this one has no use: "
                    "go on from there with --resume, or remove it",
                    folder));
  }
}

// That a level could not be reached, so that those behind it are not written. What lies under their
// names is of an earlier run, and the user's.
void tell_of_missing_levels(const std::vector<Stage>& stages, std::size_t level, const Run& run) {
  run.context.say(
      fmt::format("level {} of {} could not be reached: {} is as far as it got, and no "
                  "further level is written",
                  level + 1, stages.size(), stages[level].path));
  for (std::size_t i = level + 1; i < stages.size() && run.sink == nullptr; ++i) {
    std::error_code unknown;
    if (!std::filesystem::exists(stages[i].path, unknown)) continue;
    run.context.say(fmt::format("{} was there before and is no level of this run", stages[i].path));
  }
}

// From the input, or what an earlier run has left of it, to the last of the outputs.
template <class Real>
void coarsen(std::optional<Checkpoint> left, Run* run, SimplifyReport* report) {
  Coarsening<Real> coarsening(run);
  left ? coarsening.resume(std::move(*left)) : coarsening.import();
  const RunState<Real>& state = coarsening.state();
  describe_input(*run, state.input.facts, report);
  if (looks_at_result(run->request)) require_boundary(run->request.input, state.input.facts);
  if (run->keeps_logs()) refuse_ghosts(run->request.input, state.input.facts);
  const std::vector<Stage>& stages = coarsening.stages();
  check_earlier_levels(stages, state.outputs.size(), *run);
  bool reached = true;
  for (std::size_t i = state.outputs.size(); i < stages.size() && reached; ++i) {
    run->clock.begin("passes");
    reached = coarsening.reach(stages[i].tets);
    const bool is_final = i + 1 == stages.size();
    if (!reached && !is_final) {
      tell_of_missing_levels(stages, i, *run);
    }
    StageOutput done = write_stage(stages[i], is_final || !reached, run, &coarsening);
    report->output = done.mesh;
    if (done.verified) report->verified.push_back(std::move(*done.verified));
    coarsening.end_stage(done.mesh);
  }
  report->steering = state.field_names;
  report->rounds = state.rounds;
  report->outputs = state.outputs;
  report->has_goal = stages.back().tets.has_value();
  report->stop_reason = reached ? StopReason::kGoal : StopReason::kSaturated;
}

SimplifyReport simplify_mesh(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                             MeshSink* sink, const RunContext& context) {
  const double start = wall_seconds();
  Run run = open_run(request, std::move(source), sink, context);
  if (sink == nullptr) {
    for (const Stage& stage : plan_stages(request, kMaxTets)) clear_leftovers(stage.path);
  }
  SimplifyReport report;
  report.method = request.behaviour.method;
  report.boundary = request.behaviour.boundary;
  report.boundary_distance = request.behaviour.boundary_distance;
  report.feature_angle = request.behaviour.feature_angle.value_or(kFeatureAngle);
  report.threads = thread_count();
  try {
    const MeshDescription& mesh = run.input.description();
    auto left = run.place.open(mesh, sink != nullptr);
    if (!left) say_what_is_left(run);
    try {
      mesh.point_type == ValueType::kFloat32 ? coarsen<float>(std::move(left), &run, &report)
                                             : coarsen<double>(std::move(left), &run, &report);
    } catch (const std::bad_alloc&) {
      throw Error(ErrorCode::kMemory,
                  fmt::format("{}: the system gave no more memory: give a smaller --memory, so "
                              "that more of the mesh lies on disk, or fewer --threads",
                              request.input));
    }
  } catch (const Error& error) {
    run.place.give_up(error);
  }
  try {
    run.place.remove();
  } catch (const Error& error) {
    context.say(error.what());  // the results are there
  }
  run.clock.end();
  report.seconds = run.clock.seconds();
  report.total_seconds = wall_seconds() - start;
  report.cpu_seconds = cpu_seconds();
  report.peak_rss_bytes = peak_rss_bytes();
  report.scratch_bytes = run.place.disk_bytes();
  context.report("done", 1);
  return report;
}

}  // namespace

SimplifyReport simplify(const SimplifyRequest& request, const RunContext& context) {
  return simplify_mesh(request, nullptr, nullptr, context);
}

SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        const RunContext& context) {
  return simplify_mesh(request, std::move(source), nullptr, context);
}

SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        MeshSink* sink, const RunContext& context) {
  return simplify_mesh(request, std::move(source), sink, context);
}

}  // namespace tetfusion
