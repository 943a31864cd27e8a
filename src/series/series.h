// Many steps of one simulation in one run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/request/options.h"
#include "driver/request/report.h"

namespace tetfusion {

struct SeriesRequest {
  // What is asked for each step. Its input is not looked at; its output is that of the steps, and
  // holds "{step}", or is the name of a .pvd file that is to name them.
  SimplifyRequest job;
  // Files, or one .pvd or .series file; or one file that has several time steps itself, all of
  // which are meant unless job.behaviour.time_step says which; or one mesh whose point arrays are
  // the steps: those that a name among job.behaviour.arrays stands for which holds "{step}". Then
  // the output is one mesh, too.
  std::vector<std::string> inputs;
  // One simplification for all steps; else each is simplified by itself.
  bool shared = true;
};

struct StepArray {
  std::string name;
  double rms = 0, max = 0;  // at the original's points, as shares of the range in that step
  std::uint64_t max_at = 0;
};

struct StepReport {
  std::string label, input, output;
  std::optional<double> time;
  std::vector<StepArray> arrays;  // those that steer, of a shared series
};

struct SeriesReport {
  bool shared = true;
  std::vector<StepReport> steps;
  std::vector<SimplifyReport> runs;  // one, or one a step
  int tries = 1;                     // simplifications until the bound held at each step
  std::string list;                  // the .pvd file that was written; empty: none
  double total_seconds = 0;
};

struct SeriesPlan;

// Do these names ask for a series? `arrays` are those that steer.
bool is_series(const std::vector<std::string>& inputs, const std::string& output,
               const std::vector<std::string>& arrays);

// Throws what simplify() throws; Error(kUsage) for what a series cannot be asked for, before any
// work; Error(kBadInput) for a step that is missing, or, of a shared series, has another mesh than
// the first or not the arrays that steer. Each output appears when it is whole, the .pvd file last;
// a message about a failure says which steps are done.
SeriesReport simplify_series(const SeriesRequest& request, const RunContext& context = {});
// The same, of steps that have been planned (series_plan.h).
SeriesReport simplify_series(const SeriesRequest& request, SeriesPlan plan,
                             const RunContext& context);

std::string to_json(const SeriesReport& report);

}  // namespace tetfusion
