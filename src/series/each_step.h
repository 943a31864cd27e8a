// A job that is done for one step of a series after the other, and the list of what came out.
#pragma once

#include <functional>

#include "base/run_context.h"
#include "io/source/mesh_source.h"
#include "series/series_plan.h"

namespace tetfusion {

// Calls work() for each step, in their order, with the step's part of the context. Where a list is
// to be written, finds the step's time first, if the file says one; `open`: how, but for the time
// step. Throws Error, which says how many steps are done.
void for_each_step(SeriesPlan* plan, const OpenOptions& open, const RunContext& context,
                   const std::function<void(const Step& step, const RunContext& part)>& work);

// Writes the plan's list, if there is to be one: with the steps' times, where these tell them
// apart; else counted, which is said. Throws Error(kIo).
void write_list(const SeriesPlan& plan, const RunContext& context);

}  // namespace tetfusion
