#include "io/vtk/series_list.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "io/files/mapped_file.h"
#include "io/files/output_file.h"
#include "io/formats/suffix.h"
#include "io/vtk/listed_files.h"
#include "io/vtk/vtu_markup.h"
#include "io/formats/xml_text.h"

namespace tetfusion {

namespace {

constexpr std::string_view kOneFileAStep =
    "a step must be one file, a .pvtu if it has several parts: give each step a time of its own, "
    "and leave other files out of the list";

[[noreturn]] void fail(const MappedFile& file, const std::string& what) {
  throw Error(ErrorCode::kBadInput, file.path() + ": " + what);
}

std::vector<ListedStep> read_pvd(const MappedFile& file) {
  const pugi::xml_document document = parse_list(file);
  const auto list = document.child("VTKFile").child("Collection");
  if (!list) fail(file, "there is no <Collection>: this is no .pvd file");
  std::vector<ListedStep> entries;
  std::set<std::string> parts;  // of entries without a time, which may be those of one step
  for (const pugi::xml_node node : list.children("DataSet")) {
    const std::string number = fmt::format("DataSet {}", entries.size());
    ListedStep entry{{}, listed_path(file.path(), number, node.attribute("file").value())};
    if (const pugi::xml_attribute time = node.attribute("timestep")) {
      entry.time = number_in<double>(trimmed(time.value()));
      if (!entry.time || !std::isfinite(*entry.time)) {
        fail(file, fmt::format("{}: the timestep \"{}\" is no number", number, time.value()));
      }
    } else {
      parts.insert(node.attribute("part").as_string("0"));
    }
    entries.push_back(std::move(entry));
  }
  if (parts.size() > 1) {
    fail(file, fmt::format("it has parts without a timestep: {}", kOneFileAStep));
  }
  return entries;
}

std::vector<ListedStep> read_json(const MappedFile& file) {
  const auto* const text = reinterpret_cast<const char*>(file.bytes().data());
  const auto json = nlohmann::json::parse(text, text + file.size(), nullptr, false);
  file.check();
  if (!json.is_object() || !json.contains("files") || !json["files"].is_array()) {
    fail(file, "there is no list \"files\": this is no list of a series");
  }
  std::vector<ListedStep> entries;
  for (const auto& item : json["files"]) {
    const std::string number = fmt::format("file {}", entries.size());
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string()) {
      fail(file, number + " has no name");
    }
    ListedStep entry{{}, listed_path(file.path(), number, item["name"].get<std::string>())};
    if (item.contains("time")) {
      if (!item["time"].is_number()) fail(file, number + ": the time is no number");
      entry.time = item["time"].get<double>();
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

bool is_pvd_name(const std::string& path) { return suffix_of(path) == ".pvd"; }

bool is_list_name(const std::string& path) {
  return is_pvd_name(path) || suffix_of(path) == ".series";
}

std::vector<ListedStep> read_series_list(const std::string& path) {
  const MappedFile file = MappedFile::open(path);
  std::vector<ListedStep> steps = is_pvd_name(path) ? read_pvd(file) : read_json(file);
  if (steps.empty()) fail(file, "it names no file");
  const auto has_time = [](const ListedStep& step) { return step.time.has_value(); };
  if (std::none_of(steps.begin(), steps.end(), has_time)) return steps;
  const auto without = std::find_if_not(steps.begin(), steps.end(), has_time);
  if (without != steps.end()) {
    fail(file, fmt::format("{} has no time, but others have: give each one a time", without->path));
  }
  std::stable_sort(steps.begin(), steps.end(),
                   [](const ListedStep& a, const ListedStep& b) { return a.time < b.time; });
  const auto twin =
      std::adjacent_find(steps.begin(), steps.end(),
                         [](const ListedStep& a, const ListedStep& b) { return a.time == b.time; });
  if (twin != steps.end()) {
    fail(file,
         fmt::format("there are several files for the time {}: {}", *twin->time, kOneFileAStep));
  }
  return steps;
}

void write_pvd(const std::string& path, const std::vector<ListedStep>& steps) {
  const auto folder = std::filesystem::absolute(path).lexically_normal().parent_path();
  std::string text = vtk_file_tag("Collection", "") + "<Collection>\n";
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ListedStep& step = steps[i];
    const auto file =
        std::filesystem::absolute(step.path).lexically_normal().lexically_relative(folder);
    text += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n",
                        step.time.value_or(static_cast<double>(i)), xml_escape(file.string()));
  }
  text += "</Collection>\n</VTKFile>\n";
  OutputFile file(path);
  file.append(text.data(), text.size());
  file.commit();
}

}  // namespace tetfusion
