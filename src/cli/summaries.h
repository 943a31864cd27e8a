// What a simplification did, for people.
#pragma once

#include <string>

#include "cli/console.h"
#include "driver/report.h"
#include "series/series.h"

namespace tetfusion {

void summarize(const SimplifyReport& report, Console* console);
// `output` as it was asked for.
void summarize(const SeriesReport& report, const std::string& output, Console* console);

}  // namespace tetfusion
