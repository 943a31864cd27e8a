// A job that is done for one step of a series after the other, and the list of what came out.
#pragma once

#include <functional>

#include "base/run_context.h"
#include "io/source/mesh_source.h"
#include "series/series_plan.h"

namespace tetfusion {

// Calls work() for each step, in their order, with the step's part of the context, and does what
// the two functions below do. Where a list is to be written, finds the step's time first, if the
// file says one; `open`: how, but for the time step. Throws Error, which says how many steps are
// done.
void for_each_step(SeriesPlan* plan, const OpenOptions& open, const RunContext& context,
                   const std::function<void(const Step& step, const RunContext& part)>& work);

// Where a list gives times that its files do not have, and the outputs have no list: says so.
void say_which_times_go(const SeriesPlan& plan, const OpenOptions& open, const RunContext& context);

// Where there is an old file with the name of the plan's list: it names outputs that are being
// replaced, and goes when the first of them has been. Nothing is said where that fails.
void drop_old_list(const SeriesPlan& plan);

// Writes the plan's list, if there is to be one: with the steps' times, where these tell them
// apart; else counted, which is said. Throws Error(kIo).
void write_list(const SeriesPlan& plan, const RunContext& context);

}  // namespace tetfusion
