#include "vtk/ensight_gold.h"

#include <algorithm>
#include <array>
#include <optional>

#include "base/numbers.h"

namespace tetfusion {

namespace {

constexpr std::string_view kBlanks = " \t\r";

// As VTK reads them: lines of data are those that are not blank and no comments.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  // Without blanks round it; none: the text is over.
  std::optional<std::string_view> any() {
    if (rest_.empty()) return std::nullopt;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    line = line.substr(0, line.find_last_not_of(kBlanks) + 1);
    return line;
  }
  std::optional<std::string_view> next() {
    std::optional<std::string_view> line = any();
    while (line && (line->empty() || line->starts_with('#'))) line = any();
    return line;
  }
  std::optional<std::uint64_t> number() {
    const auto line = next();
    return line ? number_in<std::uint64_t>(*line) : std::nullopt;
  }
  // False where there are fewer before the next part.
  bool skip(std::uint64_t lines) {
    for (; lines > 0; --lines) {
      const auto line = next();
      if (!line || *line == "part") return false;
    }
    return true;
  }
  // The sum of that many numbers.
  std::optional<std::uint64_t> sum(std::uint64_t lines) {
    std::uint64_t all = 0;
    for (; lines > 0; --lines) {
      const auto value = number();
      if (!value) return std::nullopt;
      all += *value;
    }
    return all;
  }

 private:
  std::string_view rest_;
};

// Each element has a line of its own.
bool is_element(std::string_view type) {
  constexpr std::array<std::string_view, 16> kTypes{
      "point",  "bar2",    "bar3",     "tria3", "tria6",  "quad4",  "quad8",   "tetra4",
      "nsided", "tetra10", "pyramid5", "hexa8", "hexa20", "penta6", "penta15", "pyramid13"};
  if (type.starts_with("g_")) type.remove_prefix(2);  // ghosts
  return std::ranges::find(kTypes, type) != kTypes.end();
}

bool has_ids(std::string_view line) {
  return line.find("given") != std::string_view::npos ||
         line.find("ignore") != std::string_view::npos;
}

std::string fault(std::string_view what, std::uint64_t count, std::uint64_t part) {
  return "says that part " + std::to_string(part) + " has " + std::to_string(count) + " of '" +
         std::string(what) + "', and ends before: it is cut off or damaged";
}

}  // namespace

std::string EnSightGold::fault_of_geometry(std::string_view text) {
  Lines lines(text);
  lines.any();  // a description
  lines.any();
  const auto node_id = lines.next(), element_id = lines.next();
  if (!node_id || !element_id || !node_id->starts_with("node id") ||
      !element_id->starts_with("element id")) {
    return "";
  }
  const bool has_node_ids = has_ids(*node_id), has_element_ids = has_ids(*element_id);
  Part* part = nullptr;
  std::uint64_t number = 0;
  for (auto line = lines.next(); line; line = lines.next()) {
    if (*line == "extents") {
      lines.skip(3);
      continue;
    }
    if (*line == "part") {
      const auto given = lines.number();
      lines.any();  // what it is called
      if (!given) return "";
      number = *given;
      part = &parts_[number];
      continue;
    }
    if (part == nullptr || (*line != "coordinates" && *line != "nfaced" && !is_element(*line))) {
      return "";
    }
    const auto count = lines.number();
    if (!count) return fault(*line, 0, number);
    bool is_whole = true;
    if (*line == "coordinates") {
      part->nodes = *count;
      is_whole = lines.skip((has_node_ids ? *count : 0) + 3 * *count);
    } else {
      part->elements[std::string(*line)] += *count;
      is_whole = lines.skip(has_element_ids ? *count : 0);
      if (is_whole && *line == "nfaced") {
        const auto faces = lines.sum(*count);  // of each; then how many nodes, and the nodes
        is_whole = faces && lines.skip(2 * *faces);
      } else if (is_whole) {
        is_whole = lines.skip((line->ends_with("nsided") ? 2 : 1) * *count);
      }
    }
    if (!is_whole) return fault(*line, *count, number);
  }
  is_known_ = true;
  return "";
}

std::string EnSightGold::fault_of_variable(std::string_view text, std::uint64_t components) const {
  if (!is_known_) return "";
  Lines lines(text);
  lines.any();  // a description
  const Part* part = nullptr;
  std::uint64_t number = 0;
  for (auto line = lines.next(); line; line = lines.next()) {
    if (*line == "part") {
      const auto given = lines.number();
      const auto found = given ? parts_.find(*given) : parts_.end();
      if (found == parts_.end()) return "";
      number = *given;
      part = &found->second;
      continue;
    }
    if (part == nullptr) return "";
    std::uint64_t count = part->nodes;
    if (*line != "coordinates") {
      const auto found = part->elements.find(*line);
      if (found == part->elements.end()) return "";
      count = found->second;
    }
    if (!lines.skip(components * count)) {
      return "has not as many values as there are of '" + std::string(*line) + "' in part " +
             std::to_string(number) + ": it is cut off or damaged";
    }
  }
  return "";
}

}  // namespace tetfusion
