#include "series/series.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/resources.h"
#include "base/version.h"
#include "driver/request/check_options.h"
#include "driver/request/report_json.h"
#include "driver/run_setup.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/vtk/series_list.h"
#include "mesh/time_value.h"
#include "series/series_plan.h"
#include "series/shared_series.h"

namespace tetfusion {

namespace {

// The time that the file itself says.
std::optional<double> time_in(const Step& step, OpenOptions open) {
  open.time_step.reset();
  const std::vector<double> times = time_steps_of(step.input, open);
  if (!times.empty()) return times[choose_time_step(step.input, times.size(), step.time_step)];
  const auto source = open_mesh(step.input, open);
  const std::size_t index = source->description().field_data.find(kTimeValue);
  if (index == AttributeSet::npos) return {};
  return time_of(source->read_array(Association::kField, index));
}

RunContext part_of(const RunContext& context, std::size_t i, std::size_t all) {
  const auto share = [&](std::size_t done) {
    return static_cast<double>(done) / static_cast<double>(all);
  };
  RunContext part = context.part(share(i), share(i + 1));
  if (i > 0) part.size = {};
  return part;
}

SeriesReport simplify_each(const SeriesRequest& request, SeriesPlan* plan,
                           const RunContext& context) {
  SeriesReport report;
  report.shared = false;
  double cpu_before = 0;
  for (std::size_t i = 0; i < plan->steps.size(); ++i) {
    Step& step = plan->steps[i];
    SimplifyRequest job = request.job;
    job.input = step.input;
    job.output = step.output;
    job.is_step = true;
    job.behaviour.time_step = step.time_step;
    // A folder for each: with --resume the steps before one that was interrupted begin anew.
    if (!job.performance.scratch.empty()) job.performance.scratch += "-" + step.label;
    try {
      if (!step.time && !plan->list.empty()) {
        step.time = time_in(step, open_options(job, "", context));
      }
      report.runs.push_back(simplify(job, part_of(context, i, plan->steps.size())));
      report.runs.back().cpu_seconds -= std::exchange(cpu_before, report.runs.back().cpu_seconds);
    } catch (const Error& error) {
      throw Error(error.code(),
                  fmt::format("{}; steps written: {} of {}", error.what(), i, plan->steps.size()));
    }
    report.steps.push_back({step.label, step.input, step.output, step.time, {}});
  }
  return report;
}

// With the steps' times, where they tell them apart; else counted.
void write_list(const SeriesPlan& plan, const RunContext& context) {
  std::vector<ListedStep> steps;
  std::set<double> times;
  bool any = false;
  for (const Step& step : plan.steps) {
    any = any || step.time.has_value();
    if (step.time && std::isfinite(*step.time)) times.insert(*step.time);
    steps.push_back({step.time, step.output});
  }
  if (times.size() < steps.size()) {
    if (any) {
      context.say(fmt::format("{}: the steps are numbered, as {} does not tell all of them apart",
                              plan.list, kTimeValue));
    }
    for (ListedStep& step : steps) step.time.reset();
  }
  write_pvd(plan.list, steps);
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
  SeriesReport report = request.shared ? simplify_shared(request, &plan, context)
                                       : simplify_each(request, &plan, context);
  if (!plan.list.empty()) write_list(plan, context);
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
