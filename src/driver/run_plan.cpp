#include "driver/run_plan.h"

#include <nlohmann/json.hpp>

#include "base/version.h"

namespace tetfusion {

std::string to_json(const RunPlan& plan) {
  using Json = nlohmann::ordered_json;
  const RunEstimate& estimate = plan.estimate;
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
        {"reaches_goal", estimate.goal ? Json(estimate.reaches_goal()) : Json()},
        {"seconds", estimate.seconds},
        {"boundary_points_share", estimate.boundary_share},
        {"sample_tets", estimate.sample_tets},
        {"sample_seconds", estimate.sample_seconds}}}};
  // A file's name need not be UTF-8, JSON must.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tetfusion
