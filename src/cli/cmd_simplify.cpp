#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/listed_steps.h"
#include "cli/simplify_options.h"
#include "cli/summaries.h"
#include "driver/request/stages.h"
#include "driver/run_plan.h"
#include "driver/simplify.h"
#include "io/mesh_format.h"
#include "mesh/geometry.h"
#include "series/series.h"
#include "series/series_plan.h"

namespace tetfusion {

namespace {

// For --strict. The summary says it, too.
void refuse_unreached_goal(const SimplifyReport& report, bool was_summarized) {
  if (!report.has_goal || report.stop_reason == StopReason::kGoal) return;
  if (!was_summarized) print_error(report.stop_sentence());
  throw ExitStatus{ErrorCode::kGoalNotReached};
}

void run_series(SimplifyArguments* a) {
  const SeriesRequest request{a->request, a->inputs, a->series != "each"};
  // Of a file that VTK reads even the names of its steps may take long.
  SeriesPlan plan = plan_series(request, Console(a->console).context());
  const std::vector<std::string> files = files_of(plan);
  check_report(a->report, files);
  refuse_same_file("--map", a->request.map, files);
  SeriesReport report;
  {
    Console console(a->console);
    report = simplify_series(request, std::move(plan), console.context());
    summarize(report, a->request.output, &console);
  }
  if (!a->report.empty()) write_text(a->report, to_json(report));
  if (!a->strict) return;
  for (const SimplifyReport& one : report.runs) refuse_unreached_goal(one, !a->console.quiet);
}

void run_simplify(SimplifyArguments* a) {
  if (!a->report.empty()) {
    std::vector<std::string> others = a->inputs;
    for (const Stage& level : plan_stages(a->request, kMaxTets)) {
      others.insert(others.end(), {level.path, level.map});
    }
    check_report(a->report, others);
    a->request.also_written = a->report;
  }
  if (!a->series.empty() || is_series(a->inputs, a->request.output, a->request.behaviour.arrays)) {
    if (a->dry_run) throw Error(ErrorCode::kUsage, "--dry-run is for one mesh, not for a series");
    return run_series(a);
  }
  if (a->dry_run) {
    RunPlan plan;
    {
      Console console(a->console);
      plan = plan_run(a->request, console.context());
    }
    if (a->report != "-" && !a->console.quiet) write_text("-", describe(plan));
    if (!a->report.empty()) write_text(a->report, to_json(plan));
    return;
  }
  SimplifyReport report;
  {
    Console console(a->console);
    report = simplify(a->request, console.context());
    summarize(report, &console);
  }
  if (!a->report.empty()) write_text(a->report, to_json(report));
  if (a->strict) refuse_unreached_goal(report, !a->console.quiet);
}

}  // namespace

void add_simplify_command(CLI::App& app) {
  auto a = std::make_shared<SimplifyArguments>();
  CLI::App* command = app.add_subcommand("simplify", "Simplify a mesh");
  add_simplify_options(*command, a.get());
  command->callback([a] {
    parse_simplify_arguments(a.get());
    run_simplify(a.get());
  });
}

}  // namespace tetfusion
