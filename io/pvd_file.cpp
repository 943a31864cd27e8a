#include "io/pvd_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/numbers.h"
#include "io/encode.h"
#include "io/listed_files.h"
#include "io/mapped_file.h"
#include "io/output_file.h"
#include "io/vtu_markup.h"

namespace tetfusion {

bool is_pvd_name(const std::string& path) {
  std::string end = std::filesystem::path(path).extension().string();
  std::transform(end.begin(), end.end(), end.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return end == ".pvd";
}

std::vector<PvdStep> read_pvd(const std::string& path) {
  const MappedFile file = MappedFile::open(path);
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kBadInput, path + ": " + what);
  };
  const pugi::xml_document document = parse_list(file);
  const auto list = document.child("VTKFile").child("Collection");
  if (!list) fail("there is no <Collection>: this is no .pvd file");
  std::vector<PvdStep> steps;
  for (const pugi::xml_node node : list.children("DataSet")) {
    const std::string number = fmt::format("DataSet {}", steps.size());
    const std::string step = listed_path(path, number, node.attribute("file").value());
    const std::string text = node.attribute("timestep").value();
    const auto time = parse_number(text);
    if (!time) fail(fmt::format("{}: the timestep \"{}\" is no number", number, text));
    steps.push_back({*time, step});
  }
  if (steps.empty()) fail("it names no file");
  std::stable_sort(steps.begin(), steps.end(),
                   [](const PvdStep& a, const PvdStep& b) { return a.time < b.time; });
  const auto twin =
      std::adjacent_find(steps.begin(), steps.end(),
                         [](const PvdStep& a, const PvdStep& b) { return a.time == b.time; });
  if (twin != steps.end()) {
    fail(
        fmt::format("there are several files for the time {}: a step must be one file, a .pvtu if "
                    "it has several parts",
                    twin->time));
  }
  return steps;
}

void write_pvd(const std::string& path, const std::vector<PvdStep>& steps) {
  const auto folder = std::filesystem::absolute(path).lexically_normal().parent_path();
  std::string text = vtk_file_tag("Collection", "") + "<Collection>\n";
  for (const PvdStep& step : steps) {
    const auto file =
        std::filesystem::absolute(step.path).lexically_normal().lexically_relative(folder);
    text += fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", step.time,
                        xml_escape(file.string()));
  }
  text += "</Collection>\n</VTKFile>\n";
  OutputFile file(path);
  file.append(text.data(), text.size());
  file.commit();
}

}  // namespace tetfusion
