// What a simplification would take, and what it did, for people.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "cli/console.h"
#include "driver/request/report.h"
#include "driver/run_plan.h"
#include "series/series.h"

namespace tetfusion {

// What a run would take.
std::string describe(const RunPlan& plan);

// How far arrays are off at most at any step of a series: a sentence an array, by their names.
class WorstErrors {
 public:
  // `rms` and `max` as shares of the range in that step.
  void add(const std::string& array, const std::string& step, double rms, double max);
  void say(Console* console) const;

 private:
  struct Worst {
    std::pair<double, std::string> rms, max;  // and in which step
  };
  std::map<std::string, Worst> arrays_;
};

void summarize(const SimplifyReport& report, Console* console);
// `output` as it was asked for.
void summarize(const SeriesReport& report, const std::string& output, Console* console);

}  // namespace tetfusion
