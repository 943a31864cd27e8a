#include "series/each_step.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/vtk/series_list.h"
#include "mesh/time_value.h"

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

}  // namespace

void for_each_step(SeriesPlan* plan, const OpenOptions& open, const RunContext& context,
                   const std::function<void(const Step& step, const RunContext& part)>& work) {
  const std::size_t count = plan->steps.size();
  say_which_times_go(*plan, open, context);
  for (std::size_t i = 0; i < count; ++i) {
    Step& step = plan->steps[i];
    try {
      if (!step.time && !plan->list.empty()) step.time = time_in(step, open);
      work(step, part_of(context, i, count));
      if (i == 0) drop_old_list(*plan);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("{}; steps written: {} of {}",
                                            in_step(step, error).what(), i, count));
    }
  }
}

void say_which_times_go(const SeriesPlan& plan, const OpenOptions& open,
                        const RunContext& context) {
  const Step& first = plan.steps[0];
  if (!plan.list.empty() || !first.time || first.time_step || time_in(first, open) == first.time) {
    return;
  }
  context.say(
      "the times that the list gives are not those of its files, and are lost: an output called "
      "OUT.pvd keeps them");
}

void drop_old_list(const SeriesPlan& plan) {
  std::error_code not_there;
  if (!plan.list.empty()) std::filesystem::remove(plan.list, not_there);
}

void write_list(const SeriesPlan& plan, const RunContext& context) {
  if (plan.list.empty()) return;
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

}  // namespace tetfusion
