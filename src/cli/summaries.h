// What a simplification would take, and what it did, for people.
#pragma once

#include <string>

#include "cli/console.h"
#include "driver/request/report.h"
#include "driver/run_plan.h"
#include "series/series.h"

namespace tetfusion {

// What a run would take.
std::string describe(const RunPlan& plan);

void summarize(const SimplifyReport& report, Console* console);
// `output` as it was asked for.
void summarize(const SeriesReport& report, const std::string& output, Console* console);

}  // namespace tetfusion
