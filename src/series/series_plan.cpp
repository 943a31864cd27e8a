#include "series/series_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "driver/export/export.h"
#include "driver/request/check_options.h"
#include "driver/run_setup.h"
#include "io/files/output_file.h"
#include "io/formats/xml_text.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/vtk/pieces_output.h"
#include "io/vtk/series_list.h"
#include "mesh/array_names.h"
#include "mesh/regions/region_of_interest.h"
#include "series/step_labels.h"

namespace tetfusion {

namespace {

// Are the steps arrays of one mesh?
bool is_in_one_mesh(const SeriesRequest& request) {
  const std::vector<std::string>& arrays = request.job.behaviour.arrays;
  return request.inputs.size() == 1 && !is_list_name(request.inputs[0]) &&
         std::any_of(arrays.begin(), arrays.end(), holds_step);
}

void check_names(const std::vector<std::string>& inputs, const std::string& output) {
  if (inputs.size() > 1 && std::any_of(inputs.begin(), inputs.end(), is_list_name)) {
    refuse("a .pvd or .series file names all steps of a series: give it alone");
  }
  if (std::find(inputs.begin(), inputs.end(), "-") != inputs.end() || output == "-") {
    refuse("the steps of a series are files: standard input and output hold one mesh");
  }
}

// What neither kind of series can be asked for, and what a shared one cannot.
void check_request(const SeriesRequest& request) {
  const SimplifyRequest& job = request.job;
  const BehaviourOptions& b = job.behaviour;
  check_names(request.inputs, job.output);
  const auto no = [](bool given, const char* option) {
    if (given) refuse(fmt::format("{} is for one mesh, not for a series", option));
  };
  no(!b.lods.empty(), "--lods");
  no(job.pieces > 0, "--pieces");
  no(!job.progressive.empty(), "--progressive");
  if (!request.shared && !job.map.empty()) {
    refuse("--map is not for --series each, where each step has a mesh of its own: leave it out");
  }
  if (!request.shared) return;
  const auto only_each = [&](bool given, const char* option) {
    if (!given) return;
    refuse(
        is_in_one_mesh(request)
            ? fmt::format("{} is not for steps that are arrays of one mesh: leave it out", option)
            : fmt::format("{} is not for a shared series: leave it out, or give --series each",
                          option));
  };
  only_each(job.performance.resume, "--resume");
  only_each(job.verify, "--verify");
  only_each(b.conserve, "--conserve");
}

// What is a pipe, or something else that gives its bytes once.
void refuse_pipes(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    std::error_code not_there;
    if (!std::filesystem::is_other(path, not_there)) continue;
    refuse(
        fmt::format("{} can be read only once, and this series reads its files several times: copy "
                    "it to a file first",
                    path));
  }
}

void sort_by_number(std::vector<Step>* steps) {
  if (!std::ranges::all_of(*steps, is_number_label, &Step::label)) return;
  std::ranges::stable_sort(*steps, {}, [](const Step& step) { return number_in(step.label); });
}

// What stands for {step} in that name, if it is one of the pattern's.
std::optional<std::string> label_in(const std::string& name, const std::string& pattern) {
  const std::size_t begin = pattern.find(kStepField);
  const std::string end = pattern.substr(begin + std::string_view(kStepField).size());
  if (name.size() <= begin + end.size() || !name.starts_with(pattern.substr(0, begin)) ||
      !name.ends_with(end)) {
    return std::nullopt;
  }
  return name.substr(begin, name.size() - begin - end.size());
}

// The arrays whose names are like that, with {step}: the labels of their steps, and their names.
struct LabelledArrays {
  std::vector<std::pair<std::string, std::string>> steps;
  std::vector<std::string> others;  // that are no steps: of p_0, p_1 and p_mean the last one
};
LabelledArrays find_labelled(const AttributeSet& set, const std::string& pattern) {
  LabelledArrays found;
  for (const ArrayInfo& array : set.arrays) {
    const auto label = label_in(array.name, pattern);
    if (label) found.steps.emplace_back(*label, array.name);
  }
  const auto is_step = [](const auto& one) { return is_number_label(one.first); };
  if (std::any_of(found.steps.begin(), found.steps.end(), is_step)) {
    std::erase_if(found.steps, [&](const auto& one) {
      if (!is_step(one)) found.others.push_back(one.second);
      return !is_step(one);
    });
  }
  return found;
}

// The same of a name from the user, whose last colon may, as everywhere, begin a share: *pattern
// is without it.
LabelledArrays find_named(const AttributeSet& set, const std::string& name, std::string* pattern) {
  *pattern = name;
  LabelledArrays found = find_labelled(set, name);
  const std::size_t colon = name.rfind(':');
  if (found.steps.empty() && colon != std::string::npos && colon > name.find(kStepField)) {
    *pattern = name.substr(0, colon);
    found = find_labelled(set, *pattern);
  }
  return found;
}

// The steps are point arrays of one mesh. `names` are as the user has them, with {step} and maybe a
// share behind.
std::vector<Step> find_steps_in(const std::string& path, const std::vector<std::string>& names,
                                const OpenOptions& open, const RunContext& context) {
  const auto source = open_mesh(path, open);
  const MeshDescription& mesh = source->description();
  std::vector<Step> steps;
  std::string first;
  for (const std::string& name : names) {
    if (!holds_step(name)) {
      refuse(
          fmt::format("--array {}: where steps are the arrays of one mesh, each array that "
                      "steers holds {}",
                      name, kStepField));
    }
    std::string pattern;
    const auto [found, others] = find_named(mesh.point_data, name, &pattern);
    if (found.empty()) {
      refuse(fmt::format("{}: no point array is named like {}; the point arrays are: {}", path,
                         pattern, names_of(mesh.point_data)));
    }
    if (!others.empty()) {
      context.say(fmt::format("named like {}, but no steps, as theirs are numbers: {}", pattern,
                              fmt::join(others, ", ")));
    }
    if (first.empty()) {
      first = pattern;
      for (const auto& [label, array] : found)
        steps.push_back({path, label, {}, "", open.time_step, {}});
    }
    for (Step& step : steps) {
      const auto own = std::find_if(found.begin(), found.end(),
                                    [&](const auto& one) { return one.first == step.label; });
      if (own == found.end() || found.size() != steps.size()) {
        refuse(fmt::format("{}: {} and {} have not the same steps", path, first, pattern));
      }
      step.arrays[pattern] = own->second;
    }
  }
  sort_by_number(&steps);
  return steps;
}

// A region is one for all steps, in each of which the array has the name that holds {step}.
void refuse_step_as_interest(const std::vector<Step>& steps,
                             const std::vector<std::string>& interest) {
  for (const std::string& text : interest) {
    if (!RegionOfInterest::is_by_values(text)) continue;
    const std::size_t end = text.find_first_of("<>");
    for (const Step& step : steps) {
      const auto pattern = pattern_of(step, text.substr(0, end));
      if (!pattern || end == std::string::npos) continue;
      refuse(
          fmt::format("--roi '{}': {} is the array of one step: --roi '{}{}' is for each of them",
                      text, text.substr(0, end), *pattern, text.substr(end)));
    }
  }
}

// Where the file itself has several: these, or the one that is wanted.
std::vector<Step> find_steps_of(const std::string& path, const OpenOptions& open) {
  const std::vector<double> times = time_steps_of(path, open);
  if (times.empty()) return {};
  std::vector<Step> steps;
  for (std::size_t i = 0; i < times.size(); ++i) {
    steps.push_back({path, count_label(i, times.size()), times[i], "", i, {}});
  }
  if (open.time_step) steps = {steps[choose_time_step(path, times.size(), open.time_step)]};
  return steps;
}

// Those of one file, or of several that go on with a simulation, one after the other, if one of
// them has more than one step and none is chosen of each.
std::vector<Step> find_steps_inside(const std::vector<std::string>& inputs,
                                    const OpenOptions& open) {
  if (inputs.size() == 1) return find_steps_of(inputs[0], open);
  if (open.time_step) return {};
  std::vector<Step> steps;
  for (const std::string& path : inputs) {
    const std::vector<Step> own = find_steps_of(path, open);
    if (own.empty()) return {};
    steps.insert(steps.end(), own.begin(), own.end());
  }
  if (steps.size() == inputs.size()) return {};
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i].label = count_label(i, steps.size());
  return steps;
}

std::vector<Step> find_steps(const std::vector<std::string>& inputs, const OpenOptions& open) {
  std::vector<Step> steps;
  const bool is_list = inputs.size() == 1 && is_list_name(inputs[0]);
  if (is_list) {
    for (const ListedStep& step : read_series_list(inputs[0]))
      steps.push_back({step.path, "", step.time, "", {}, {}});
    if (open.time_step) steps = {steps[choose_time_step(inputs[0], steps.size(), open.time_step)]};
  } else {
    steps = find_steps_inside(inputs, open);
    if (!steps.empty()) return steps;
    for (const std::string& path : inputs) steps.push_back({path, "", {}, "", open.time_step, {}});
  }
  std::vector<std::string> paths;
  for (const Step& step : steps) paths.push_back(step.input);
  const std::vector<std::string> labels = label_steps(paths);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i].label = labels[i];
  if (!is_list) sort_by_number(&steps);
  return steps;
}

// The name of each step's output, which holds {step} where there are several, and of their list.
struct OutputNames {
  std::string pattern, list;
};

OutputNames names_of_outputs(const std::string& output) {
  if (!is_pvd_name(output)) return {output, ""};
  if (holds_step(output)) {
    refuse(fmt::format("{}: a .pvd file is one for all steps: leave {} out", output, kStepField));
  }
  if (!is_xml_text(output)) {
    refuse(fmt::format("{}: a .pvd file holds names in UTF-8: give another one", output));
  }
  check_output_path(output);
  const std::string stem = std::filesystem::path(output).replace_extension().string();
  return {fmt::format("{}_{}.vtu", stem, kStepField), output};
}

void check_outputs(const SeriesPlan& plan, const StepsRequest& request) {
  const std::vector<Step>& steps = plan.steps;
  OpenOptions open = request.open;
  open.time_step.reset();  // pieces have none
  const auto plain = [](const std::string& path) {
    std::error_code ignored;
    const auto real = std::filesystem::weakly_canonical(path, ignored);
    return (ignored ? std::filesystem::absolute(path).lexically_normal() : real).string();
  };
  std::set<std::string> read;
  for (const std::string& path : request.inputs) read.insert(plain(path));
  for (const Step& step : steps) {
    for (const std::string& path : files_of_mesh(step.input)) read.insert(plain(path));
    if (!is_pieces_name(step.input)) continue;
    const auto mesh = open_mesh(step.input, open);
    for (const std::string& piece : mesh->description().files) read.insert(plain(piece));
  }
  const auto refuse_input = [&](const std::string& path) {
    if (path.empty() || !read.contains(plain(path))) return;
    refuse(fmt::format("{} is an input of the series: give the outputs another name", path));
  };
  refuse_input(plan.list);
  for (const std::string& path : request.also_written) refuse_input(path);
  std::map<std::string, std::string> written;  // by their input
  for (const Step& step : steps) {
    if (is_pieces_name(step.output)) refuse("the output of a series is one file a step, no .pvtu");
    for (const std::string& path : files_of_mesh(step.output)) refuse_input(path);
    const auto [twin, is_new] = written.emplace(plain(step.output), step.input);
    if (!is_new && !plan.in_one_mesh()) {
      const std::string of = twin->second == step.input
                                 ? "all time steps of " + step.input
                                 : fmt::format("both {} and {}", twin->second, step.input);
      refuse(fmt::format(
          "{} would be the output of {}: its name must hold {}, or be that of a .pvd{}",
          step.output, of, kStepField,
          request.inputs.size() == 1 ? ", or one of them be chosen (--time-step)" : ""));
    }
    check_export(step.output, request.encoding);
  }
}

SeriesPlan with_outputs(std::vector<Step> steps, const OutputNames& names,
                        const StepsRequest& request) {
  SeriesPlan plan{std::move(steps), names.list};
  for (Step& step : plan.steps) step.output = with_field(names.pattern, kStepField, step.label);
  check_outputs(plan, request);
  return plan;
}

}  // namespace

bool holds_step(const std::string& name) { return name.find(kStepField) != std::string::npos; }

std::optional<std::string> pattern_of(const Step& step, const std::string& name) {
  for (const auto& [pattern, own] : step.arrays) {
    if (own == name) return pattern;
  }
  return std::nullopt;
}

bool is_series(const std::vector<std::string>& inputs, const std::string& output,
               const std::vector<std::string>& arrays) {
  return inputs.size() > 1 || is_pvd_name(output) ||
         (inputs.size() == 1 && is_list_name(inputs[0])) || holds_step(output) ||
         std::any_of(arrays.begin(), arrays.end(), holds_step);
}

std::vector<std::string> labels_of(const SeriesPlan& plan) {
  std::vector<std::string> labels;
  for (const Step& step : plan.steps) labels.push_back(step.label);
  return labels;
}

Error in_step(const Step& step, const Error& error) {
  if (!step.time_step) return error;
  return {error.code(),
          fmt::format("step {} of {}: {}", *step.time_step, step.input, error.what())};
}

SeriesPlan plan_steps(const StepsRequest& request) {
  check_names(request.inputs, request.output);
  const OutputNames names = names_of_outputs(request.output);
  if (!names.list.empty()) refuse_pipes(request.inputs);
  return with_outputs(find_steps(request.inputs, request.open), names, request);
}

SeriesPlan plan_series(const SeriesRequest& request, const RunContext& context) {
  check_request(request);
  check_options(request.job);
  if (!request.job.map.empty()) check_output_path(request.job.map);
  const OutputNames names = names_of_outputs(request.job.output);
  const std::vector<std::string>& arrays = request.job.behaviour.arrays;
  const bool in_one_mesh = is_in_one_mesh(request);
  if (in_one_mesh && (!request.shared || !names.list.empty() || holds_step(names.pattern))) {
    refuse(
        fmt::format("{}: where steps are the arrays of one mesh, the result is one mesh with all "
                    "of them: give one name after -o, and not --series each",
                    request.inputs[0]));
  }
  if (in_one_mesh) {
    for (const std::string& array : arrays) {
      if (array.starts_with("cell:")) {
        refuse(
            fmt::format("--array {}: where steps are the arrays of one mesh those of points "
                        "steer; leave it out",
                        array));
      }
    }
  }
  // --series each reads each step once, but for its time, which a .pvd file wants.
  if (request.shared || !names.list.empty()) refuse_pipes(request.inputs);
  const StepsRequest files{request.inputs,
                           request.job.output,
                           request.job.encoding,
                           open_options(request.job, "", context),
                           {request.job.map, request.job.also_written}};
  std::vector<Step> steps = in_one_mesh
                                ? find_steps_in(request.inputs[0], arrays, files.open, context)
                                : find_steps(request.inputs, files.open);
  if (in_one_mesh) refuse_step_as_interest(steps, request.job.behaviour.interest);
  return with_outputs(std::move(steps), names, files);
}

}  // namespace tetfusion
