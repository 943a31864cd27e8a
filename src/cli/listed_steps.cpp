#include "cli/listed_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "io/open_mesh.h"
#include "io/vtk/series_list.h"

namespace tetfusion {

namespace {

// As a list of them has them, which has no times where these do not tell all steps apart.
void sort_by_time(std::vector<StepToRead>* steps) {
  std::set<double> times;
  for (const StepToRead& step : *steps) {
    if (std::isfinite(*step.time)) times.insert(*step.time);
  }
  if (times.size() == steps->size()) std::ranges::stable_sort(*steps, {}, &StepToRead::time);
}

}  // namespace

std::vector<StepToRead> steps_to_read(const std::string& input, const OpenOptions& open) {
  std::vector<StepToRead> steps;
  const bool is_list = is_list_name(input);
  if (is_list) {
    for (const ListedStep& step : read_series_list(input)) {
      steps.push_back({step.path, step.time, {}});
    }
  } else {
    const std::vector<double> times = time_steps_of(input, open);
    for (std::size_t i = 0; i < times.size() && times.size() > 1; ++i) {
      steps.push_back({input, times[i], i});
    }
  }
  if (steps.empty()) return {{input, {}, {}}};
  if (open.time_step) return {steps[choose_time_step(input, steps.size(), open.time_step)]};
  if (!is_list) sort_by_time(&steps);
  return steps;
}

bool has_own_steps(const std::string& input, const OpenOptions& open) {
  return input != "-" && !is_list_name(input) && time_steps_of(input, open).size() > 1;
}

std::string name_of(const StepToRead& step) {
  return step.time_step ? fmt::format("{}, time step {}", step.path, *step.time_step) : step.path;
}

void take_chosen_step(std::vector<std::string>* inputs, const std::string& output,
                      std::optional<std::uint64_t>* time_step) {
  const bool is_one = inputs->size() == 1 && !is_pvd_name(output) && !holds_step(output);
  if (!is_one || !*time_step || !is_list_name(inputs->front())) return;
  OpenOptions open;
  open.time_step = *time_step;
  inputs->front() = steps_to_read(inputs->front(), open)[0].path;
  time_step->reset();
}

std::optional<SeriesPlan> plan_if_series(StepsRequest* request) {
  take_chosen_step(&request->inputs, request->output, &request->open.time_step);
  if (!is_series(request->inputs, request->output, {})) return std::nullopt;
  return plan_steps(*request);
}

Step only_mesh(const StepsRequest& request) {
  Step mesh;
  mesh.input = request.inputs[0];
  mesh.output = request.output;
  mesh.time_step = request.open.time_step;
  return mesh;
}

std::vector<std::string> files_of(const SeriesPlan& plan) {
  std::vector<std::string> files;
  for (const Step& step : plan.steps) files.insert(files.end(), {step.input, step.output});
  if (!plan.list.empty()) files.push_back(plan.list);
  return files;
}

Json step_json(const StepToRead& step) {
  Json json{{"path", step.path}};
  if (step.time_step) json["time_step"] = *step.time_step;
  if (step.time) json["time"] = *step.time;
  return json;
}

}  // namespace tetfusion
