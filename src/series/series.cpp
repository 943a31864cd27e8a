#include "series/series.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/resources.h"
#include "base/version.h"
#include "driver/request/check_options.h"
#include "driver/request/report_json.h"
#include "driver/run_setup.h"
#include "driver/simplify.h"
#include "series/each_step.h"
#include "series/series_plan.h"
#include "series/shared_series.h"

namespace tetfusion {

namespace {

SeriesReport simplify_each(const SeriesRequest& request, SeriesPlan* plan,
                           const RunContext& context) {
  SeriesReport report;
  report.shared = false;
  double cpu_before = 0;
  const auto simplify_step = [&](const Step& step, const RunContext& part) {
    SimplifyRequest job = request.job;
    job.input = step.input;
    job.output = step.output;
    job.is_step = true;
    job.behaviour.time_step = step.time_step;
    // A folder for each: with --resume the steps before one that was interrupted begin anew.
    if (!job.performance.scratch.empty()) job.performance.scratch += "-" + step.label;
    report.runs.push_back(simplify(job, part));
    report.runs.back().cpu_seconds -= std::exchange(cpu_before, report.runs.back().cpu_seconds);
    report.steps.push_back({step.label, step.input, step.output, step.time, {}});
  };
  for_each_step(plan, open_options(request.job, "", context), context, simplify_step);
  return report;
}

}  // namespace

SeriesReport simplify_series(const SeriesRequest& request, const RunContext& context) {
  return simplify_series(request, plan_series(request, context), context);
}

SeriesReport simplify_series(const SeriesRequest& request, SeriesPlan plan,
                             const RunContext& context) {
  const double start = wall_seconds();
  SimplifyRequest first = request.job;
  first.output = plan.steps[0].output;
  check_options(first);
  if (request.shared) {
    say_which_times_go(plan, open_options(request.job, "", context), context);
  }
  SeriesReport report = request.shared ? simplify_shared(request, &plan, context)
                                       : simplify_each(request, &plan, context);
  write_list(plan, context);
  report.list = plan.list;
  report.total_seconds = wall_seconds() - start;
  context.report("done", 1);
  return report;
}

std::string to_json(const SeriesReport& report) {
  using Json = nlohmann::ordered_json;
  Json json;
  if (report.shared) json = to_json_value(report.runs[0]);
  json["version"] = version();
  json["series"] = report.shared ? "shared" : "each";
  if (!report.list.empty()) json["list"] = report.list;
  if (report.shared) json["tries"] = report.tries;
  Json steps = Json::array();
  for (std::size_t i = 0; i < report.steps.size(); ++i) {
    const StepReport& step = report.steps[i];
    Json entry{{"step", step.label}, {"input", step.input}, {"output", step.output}};
    if (step.time) entry["time"] = *step.time;
    if (!report.shared) entry["run"] = to_json_value(report.runs[i]);
    for (const StepArray& array : step.arrays) {
      entry["arrays"].push_back({{"name", array.name},
                                 {"rms", array.rms},
                                 {"max", array.max},
                                 {"max_at_point", array.max_at}});
    }
    steps.push_back(std::move(entry));
  }
  json["steps"] = std::move(steps);
  json["seconds"]["total"] = report.total_seconds;
  if (!report.shared) {
    json["cpu_seconds"] = cpu_seconds();
    json["peak_rss_bytes"] = peak_rss_bytes();
    json["threads"] = thread_count();
  }
  return dump(json);
}

}  // namespace tetfusion
