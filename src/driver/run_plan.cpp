#include "driver/run_plan.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/blocks.h"
#include "base/resources.h"
#include "base/version.h"
#include "driver/arrays/regions.h"
#include "driver/request/report_json.h"
#include "driver/run.h"
#include "driver/scratch_place.h"

namespace tetfusion {

namespace {

// Of a sample: it is scattered, put together and kept.
std::uint64_t most_in_memory(const Run& run) {
  constexpr double kCopies = 8;
  const auto tets = static_cast<double>(std::max<std::uint64_t>(run.input.description().cells, 1));
  const double bytes_a_tet = static_cast<double>(run.place.needs().pieces) / tets;
  const auto room = static_cast<double>(run.place.budget()->free());
  return static_cast<std::uint64_t>(room / (kCopies * std::max(bytes_a_tet, 1.0)));
}

}  // namespace

RunPlan plan_run(const SimplifyRequest& request, const RunContext& context,
                 std::uint64_t sample_tets) {
  const double start = wall_seconds();
  Run run = open_run(request, nullptr, nullptr, context);
  const MeshDescription& mesh = run.input.description();
  run.place.check_place(mesh);
  RunPlan plan;
  plan.input.path = request.input;
  plan.input.points = mesh.points;
  plan.input.tets = mesh.cells;
  plan.regions = names_of_cell_arrays(mesh, run.input.regions);
  plan.chunks = block_count(mesh.cells, request.behaviour.chunk_tets);
  plan.needs = run.place.needs();
  plan.memory = run.place.budget()->total();
  plan.on_disk = run.place.on_disk();
  plan.scratch = scratch_folder(request);
  if (mesh.spooled_checksum) plan.spooled = mesh.file_bytes;
  plan.method = request.behaviour.method;
  plan.threads = thread_count();
  plan.verifies = request.verify;
  Steering steering = read_steering(&run);
  plan.steering = steering.names();
  plan.estimate = estimate_run(run, &steering, std::min(sample_tets, most_in_memory(run)), start);
  context.report("done", 1);
  return plan;
}

std::string to_json(const RunPlan& plan) {
  using Json = nlohmann::ordered_json;
  const RunEstimate& estimate = plan.estimate;
  const std::optional<bool> reaches = estimate.reaches_goal();
  const Json json = {
      {"version", version()},
      {"method", plan.method == Method::kFuse ? "fuse" : "tetfuse"},
      {"input",
       {{"path", plan.input.path}, {"points", plan.input.points}, {"tets", estimate.tets}}},
      {"steering", plan.steering},
      {"regions", plan.regions},
      {"chunks", plan.chunks},
      {"threads", plan.threads},
      {"memory_bytes", plan.memory_needed()},
      {"memory_bytes_in_core", plan.needs.in_core},
      {"memory_allowed_bytes", plan.memory},
      {"scratch_bytes", plan.scratch_needed()},
      {"scratch", plan.on_disk ? Json(plan.scratch) : Json()},
      {"estimate",
       {{"reduction", estimate.reduction},
        {"reduction_low", estimate.is_rough ? Json(estimate.low_reduction()) : Json()},
        {"reaches_goal", reaches ? Json(*reaches) : Json()},
        {"seconds", estimate.seconds},
        {"boundary_points_share", estimate.boundary_share},
        {"sample_tets", estimate.sample_tets},
        {"sample_seconds", estimate.sample_seconds}}}};
  return dump(json);
}

}  // namespace tetfusion
