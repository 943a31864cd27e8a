// One simplification for all steps.
#pragma once

#include "base/run_context.h"
#include "series/series.h"
#include "series/series_plan.h"

namespace tetfusion {

// As simplify_series(), of a request with `shared`, but for the .pvd file. Sets the times of steps
// that say theirs.
SeriesReport simplify_shared(const SeriesRequest& request, SeriesPlan* plan,
                             const RunContext& context);

}  // namespace tetfusion
