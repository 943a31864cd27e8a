#include "io/gmsh/gmsh_steps.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "base/name_list.h"
#include "base/numbers.h"

namespace tetfusion {

namespace {

constexpr std::string_view kAt = " at ";

// "T at 0.5" as T and 0.5, where it is the name of a step.
std::optional<GmshStep> parse_step(const std::string& array) {
  const std::size_t at = array.rfind(kAt);
  if (at == std::string::npos || at == 0) return {};
  GmshStep step{array.substr(0, at)};
  const auto time = number_in<double>(std::string_view(array).substr(at + kAt.size()));
  if (!time || !std::isfinite(*time)) return {};
  step.time = *time;
  return step;
}

std::optional<double> time_of(const GmshData& data) {
  return data.time && std::isfinite(*data.time) ? data.time : std::nullopt;
}

}  // namespace

std::vector<std::string> gmsh_array_names(const std::vector<GmshData>& sections) {
  std::map<std::string, std::set<double>> times;
  for (const GmshData& data : sections) {
    if (const auto time = time_of(data)) times[data.name].insert(*time);
  }
  std::vector<std::string> names;
  for (const GmshData& data : sections) {
    const auto time = time_of(data);
    const bool is_step = time && times[data.name].size() > 1;
    names.push_back(is_step ? fmt::format("{}{}{}", data.name, kAt, *time) : data.name);
  }
  return names;
}

GmshTime gmsh_time_of(const GmshHead& head) {
  std::set<double> times;
  std::vector<std::string> with_time;
  for (const auto* all : {&head.node_data, &head.element_data}) {
    const std::vector<std::string> names = gmsh_array_names(*all);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const GmshData& data = (*all)[i];
      const bool is_step = names[i] != data.name;
      if (is_step || !time_of(data)) continue;
      times.insert(*time_of(data));
      with_time.push_back(data.name);
    }
  }
  if (times.size() == 1) {
    const double time = *times.begin();
    return {time != 0 ? std::optional(time) : std::nullopt, ""};
  }
  if (times.empty()) return {};
  constexpr std::size_t kMost = 8;
  return {{}, "the different times of " + list_names(with_time, kMost)};
}

std::vector<GmshStep> gmsh_steps_of(const AttributeSet& set, double time) {
  std::map<std::string, std::uint64_t> counts;
  for (const ArrayInfo& info : set.arrays) {
    if (const auto step = parse_step(info.name)) ++counts[step->name];
  }
  std::map<std::string, std::uint64_t> numbers;
  std::vector<GmshStep> steps;
  for (const ArrayInfo& info : set.arrays) {
    auto step = parse_step(info.name);
    if (step && counts[step->name] > 1) {
      step->number = numbers[step->name]++;
      steps.push_back(*step);
    } else {
      steps.push_back({info.name, time});
    }
  }
  return steps;
}

}  // namespace tetfusion
