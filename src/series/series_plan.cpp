#include "series/series_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/numbers.h"
#include "driver/export.h"
#include "driver/stages.h"
#include "io/output_file.h"
#include "io/pieces_output.h"
#include "io/pvd_file.h"

namespace tetfusion {

namespace {

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::kUsage, message); }

// Of a letter in UTF-8, but for its first byte.
bool goes_on(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

std::string last_number(const std::string& name) {
  std::size_t end = name.size();
  while (end > 0 && !is_digit(name[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && is_digit(name[begin - 1])) --begin;
  return name.substr(begin, end - begin);
}

// What stands between the beginnings and the ends that all names have in common, and what is left
// of a number that begins or ends in these.
std::vector<std::string> differences(const std::vector<std::string>& names) {
  std::size_t begin = names[0].size(), end = names[0].size();
  for (const std::string& name : names) {
    const auto ends = std::mismatch(names[0].begin(), names[0].end(), name.begin(), name.end());
    begin = std::min(begin, static_cast<std::size_t>(ends.first - names[0].begin()));
    const auto starts =
        std::mismatch(names[0].rbegin(), names[0].rend(), name.rbegin(), name.rend());
    end = std::min(end, static_cast<std::size_t>(starts.first - names[0].rbegin()));
  }
  const std::string& any = names[0];
  while (begin > 0 && is_digit(any[begin - 1])) --begin;
  while (end > 0 && is_digit(any[any.size() - end])) --end;
  // Whole letters, too: those that differ may begin or end with the same bytes.
  const auto cut = [&](std::size_t from_begin) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return from_begin < name.size() && goes_on(name[from_begin]);
    });
  };
  while (begin > 0 && cut(begin)) --begin;
  while (end > 0 && goes_on(any[any.size() - end])) --end;
  std::vector<std::string> labels;
  for (const std::string& name : names) {
    labels.push_back(begin + end < name.size() ? name.substr(begin, name.size() - begin - end)
                                               : std::string());
  }
  return labels;
}

bool is_number(const std::string& label) {
  return !label.empty() && label.size() < 19 && std::all_of(label.begin(), label.end(), is_digit);
}

std::string with_label(std::string pattern, const std::string& label) {
  const std::string_view field = kStepField;
  for (std::size_t at = pattern.find(field); at != std::string::npos;
       at = pattern.find(field, at + label.size())) {
    pattern.replace(at, field.size(), label);
  }
  return pattern;
}

// What neither kind of series can be asked for, and what a shared one cannot.
void check_request(const SeriesRequest& request) {
  const SimplifyRequest& job = request.job;
  const BehaviourOptions& b = job.behaviour;
  if (request.inputs.size() > 1 &&
      std::any_of(request.inputs.begin(), request.inputs.end(), is_pvd_name)) {
    refuse("a .pvd file names all steps of a series: give it alone");
  }
  if (std::find(request.inputs.begin(), request.inputs.end(), "-") != request.inputs.end() ||
      job.output == "-") {
    refuse("the steps of a series are files: standard input and output hold one mesh");
  }
  const auto no = [](bool given, const char* option) {
    if (given) refuse(fmt::format("{} is for one mesh, not for a series", option));
  };
  no(!b.lods.empty(), "--lods");
  no(job.performance.dry_run, "--dry-run");
  no(job.pieces > 0, "--pieces");
  no(!job.progressive.empty(), "--progressive");
  if (!request.shared) return no(!job.map.empty(), "--map");
  const auto only_each = [](bool given, const char* option) {
    if (!given) return;
    refuse(
        fmt::format("{} is not for a shared series: leave it out, or give --series each", option));
  };
  only_each(job.performance.resume, "--resume");
  only_each(job.verify, "--verify");
  only_each(b.conserve, "--conserve");
  for (const std::string& name : b.arrays) {
    only_each(name.starts_with("cell:"), "an array of cells that steers");
  }
  for (const std::string& text : b.interest) {
    const bool has_place = text.starts_with("box=") || text.starts_with("sphere=");
    only_each(!has_place, "a region of interest by the values of an array");
  }
}

std::vector<Step> find_steps(const std::vector<std::string>& inputs) {
  std::vector<Step> steps;
  if (inputs.size() == 1 && is_pvd_name(inputs[0])) {
    for (const PvdStep& step : read_pvd(inputs[0])) steps.push_back({step.path, "", step.time, ""});
  } else {
    for (const std::string& path : inputs) steps.push_back({path, "", {}, ""});
  }
  std::vector<std::string> paths;
  for (const Step& step : steps) paths.push_back(step.input);
  const std::vector<std::string> labels = label_steps(paths);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i].label = labels[i];
  if (!steps[0].time && std::all_of(labels.begin(), labels.end(), is_number)) {
    std::stable_sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) {
      return std::stoull(a.label) < std::stoull(b.label);
    });
  }
  return steps;
}

void check_outputs(const SeriesPlan& plan, const std::vector<std::string>& inputs,
                   const SimplifyRequest& job) {
  const std::vector<Step>& steps = plan.steps;
  const auto plain = [](const std::string& path) {
    std::error_code ignored;
    const auto real = std::filesystem::weakly_canonical(path, ignored);
    return (ignored ? std::filesystem::absolute(path).lexically_normal() : real).string();
  };
  std::set<std::string> read;
  for (const std::string& path : inputs) read.insert(plain(path));
  for (const Step& step : steps) read.insert(plain(step.input));
  const auto refuse_input = [&](const std::string& path) {
    if (path.empty() || !read.contains(plain(path))) return;
    refuse(fmt::format("{} is an input of the series: give the outputs another name", path));
  };
  refuse_input(plan.list);
  std::map<std::string, std::string> written;  // by their input
  for (const Step& step : steps) {
    if (is_pieces_name(step.output)) refuse("the output of a series is one file a step, no .pvtu");
    refuse_input(step.output);
    const auto [twin, is_new] = written.emplace(plain(step.output), step.input);
    if (!is_new) {
      refuse(fmt::format("{} would be the output of both {} and {}: the name after -o must hold {}",
                         step.output, twin->second, step.input, kStepField));
    }
    check_export(step.output, job.encoding);
  }
}

}  // namespace

bool is_series(const std::vector<std::string>& inputs, const std::string& output) {
  return inputs.size() > 1 || is_pvd_name(output) ||
         (inputs.size() == 1 && is_pvd_name(inputs[0])) ||
         output.find(kStepField) != std::string::npos;
}

std::vector<std::string> label_steps(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) {
    names.push_back(std::filesystem::path(path).filename().string());
  }
  std::vector<std::string> labels =
      names.size() == 1 ? std::vector{last_number(std::filesystem::path(names[0]).stem().string())}
                        : differences(names);
  const std::set<std::string> different(labels.begin(), labels.end());
  if (different.size() == labels.size() && !different.contains("")) return labels;
  for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = std::to_string(i);
  return labels;
}

SeriesPlan plan_series(const SeriesRequest& request) {
  check_request(request);
  check_options(request.job);
  if (!request.job.map.empty()) check_output_path(request.job.map);
  SeriesPlan plan;
  std::string pattern = request.job.output;
  if (is_pvd_name(pattern)) {
    plan.list = pattern;
    if (pattern.find(kStepField) != std::string::npos) {
      refuse(
          fmt::format("{}: a .pvd file is one for all steps: leave {} out", pattern, kStepField));
    }
    pattern =
        std::filesystem::path(pattern).replace_extension().string() + "_" + kStepField + ".vtu";
    check_output_path(plan.list);
  }
  plan.steps = find_steps(request.inputs);
  for (Step& step : plan.steps) step.output = with_label(pattern, step.label);
  check_outputs(plan, request.inputs, request.job);
  return plan;
}

}  // namespace tetfusion
