#include "vtk/ensight_case.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/numbers.h"
#include "io/files/mapped_file.h"
#include "vtk/ensight_gold.h"

namespace tetfusion {
namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// The first of `words` where it is a number and another word follows, taken from them.
std::optional<int> take_number(std::vector<std::string>* words) {
  if (words->size() < 2) return {};
  const auto number = number_in<int>(words->front());
  if (number) words->erase(words->begin());
  return number;
}

bool is_section(const std::vector<std::string>& words) {
  return words.size() == 1 &&
         std::all_of(words[0].begin(), words[0].end(), [](char c) { return c >= 'A' && c <= 'Z'; });
}

std::string with_number(std::string pattern, int number) {
  const std::size_t begin = pattern.find('*');
  const std::size_t width = pattern.find_last_of('*') + 1 - begin;
  const std::string digits = std::to_string(number);
  const std::size_t zeros = width > digits.size() ? width - digits.size() : 0;
  return pattern.replace(begin, width, std::string(zeros, '0') + digits);
}

bool matches(const std::string& name, const std::string& pattern) {
  const std::size_t begin = pattern.find('*');
  const std::size_t behind = pattern.size() - (pattern.find_last_of('*') + 1);
  if (name.size() <= begin + behind) return false;
  const std::string digits = name.substr(begin, name.size() - begin - behind);
  return name.starts_with(pattern.substr(0, begin)) &&
         name.ends_with(pattern.substr(pattern.size() - behind)) &&
         number_in<int>(digits).has_value();
}

// The files whose names have a number in the place of the asterisks, sorted.
std::vector<std::string> all_matching(const std::string& path) {
  const std::filesystem::path pattern(path);
  std::vector<std::string> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(
           pattern.has_parent_path() ? pattern.parent_path() : ".", ignored)) {
    const std::string name = entry.path().filename().string();
    if (matches(name, pattern.filename().string())) {
      found.push_back((pattern.parent_path() / name).string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool has_marks(const std::string& path, std::string_view mark, std::size_t wanted) {
  const MappedFile file = MappedFile::open(path);
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.size());
  std::size_t at = 0;
  for (; wanted > 0; --wanted) {
    at = text.find(mark, at);
    if (at == std::string_view::npos) return false;
    at += mark.size();
  }
  return true;
}

// Does a line with how many there are follow?
bool is_counted(std::string_view line) {
  constexpr std::array<std::string_view, 18> kKinds{
      "coordinates", "point",  "bar2",   "bar3",    "tria3",    "tria6",
      "quad4",       "quad8",  "tetra4", "tetra10", "pyramid5", "pyramid13",
      "hexa8",       "hexa20", "penta6", "penta15", "nsided",   "nfaced"};
  if (line.starts_with("g_")) line.remove_prefix(2);  // ghosts
  return std::find(kKinds.begin(), kKinds.end(), line) != kKinds.end();
}

// Could that many lines of a digit or more be in the text? True of what is no number.
bool is_count_of_lines(std::string_view number, std::size_t bytes) {
  std::int64_t count = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), count);
  if (error == std::errc::invalid_argument) return true;
  if (error != std::errc{} || count < 0) return false;
  return static_cast<std::uint64_t>(count) <= (bytes + 1) / 2;
}

// Of a variable; 0: it is another file, or of a kind that is not looked at.
std::uint64_t components_of(const std::string& kind) {
  constexpr std::array<std::pair<std::string_view, std::uint64_t>, 4> kKinds{
      {{"scalar per ", 1}, {"vector per ", 3}, {"tensor symm per ", 6}, {"tensor asym per ", 9}}};
  for (const auto& [begin, components] : kKinds) {
    if (kind.starts_with(begin)) return components;
  }
  return 0;
}

}  // namespace

bool is_ensight_text(std::string_view file) {
  return file.substr(0, 4096).find('\0') == std::string_view::npos;
}

EnSightCase::EnSightCase(const std::string& path)
    : folder_(std::filesystem::path(path).parent_path().string()) {
  std::ifstream file(path);
  std::string section, key;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (is_section(words)) {
      section = words[0];
      key.clear();
      continue;
    }
    // A line without a key goes on with the values of the one before.
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) {
      take_line(section, key, words);
      continue;
    }
    key.clear();
    for (const std::string& word : words_of(line.substr(0, colon))) {
      key += (key.empty() ? "" : " ") + word;
    }
    take_line(section, key, words_of(line.substr(colon + 1)));
  }
  for (TimeSet& set : sets_) {
    for (int i = static_cast<int>(set.numbers.size()); i < set.steps; ++i) {
      // In the end one that no file has, if it is too large.
      const std::int64_t number = set.start + std::int64_t{i} * set.increment;
      set.numbers.push_back(static_cast<int>(std::clamp<std::int64_t>(number, INT_MIN, INT_MAX)));
    }
  }
}

void EnSightCase::take_line(const std::string& section, const std::string& key,
                            const std::vector<std::string>& words) {
  if (section == "GEOMETRY" || section == "VARIABLE") take_file(section, key, words);
  if (section == "TIME") take_time(key, words);
  if (section == "FORMAT" && key == "type") {
    is_gold_ = std::find(words.begin(), words.end(), "gold") != words.end();
  }
  if (section == "FILE" && key == "file set") has_file_sets_ = true;
}

// [time set [file set]] name, and before the name of a variable's file its own.
void EnSightCase::take_file(const std::string& section, const std::string& key,
                            std::vector<std::string> words) {
  if (words.empty()) return;
  if (key.starts_with("constant")) {
    take_number(&words);
    variables_.push_back(words[0]);
    return;
  }
  if (section == "GEOMETRY" && key != "model" && key != "measured") return;
  NamedFile file;
  file.kind = key;
  if (const auto set = take_number(&words)) {
    file.time_set = *set;
    file.in_file_set = take_number(&words).has_value();
  }
  const std::size_t first = section == "VARIABLE" ? 1 : 0;
  if (first == 1 && !key.starts_with("complex")) variables_.push_back(words[0]);
  const std::size_t names = key.starts_with("complex") ? 2 : 1;
  for (std::size_t i = first; i < words.size() && i < first + names; ++i) {
    file.pattern = words[i];
    files_.push_back(file);
  }
}

void EnSightCase::take_time(const std::string& key, const std::vector<std::string>& words) {
  if (words.empty()) return;
  const int number = number_in<int>(words[0]).value_or(0);
  if (key == "time set") {
    sets_.emplace_back();
    sets_.back().id = number;
  }
  if (sets_.empty()) return;
  TimeSet& set = sets_.back();
  if (key == "number of steps") set.steps = std::min(number, 1 << 20);
  if (key == "filename start number") set.start = number;
  if (key == "filename increment") set.increment = number;
  for (const std::string& word : words) {
    if (key == "filename numbers") set.numbers.push_back(number_in<int>(word).value_or(0));
    if (key == "time values") set.times.push_back(number_in<double>(word).value_or(0));
  }
}

std::vector<double> EnSightCase::times() const {
  std::vector<double> times;
  for (const TimeSet& set : sets_) times.insert(times.end(), set.times.begin(), set.times.end());
  return times;
}

std::size_t EnSightCase::TimeSet::step_at(double time) const {
  std::size_t step = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (static_cast<float>(times[i]) <= static_cast<float>(time)) step = i;
  }
  return step;
}

const EnSightCase::TimeSet* EnSightCase::time_set(int id) const {
  const auto found =
      std::find_if(sets_.begin(), sets_.end(), [&](const TimeSet& set) { return set.id == id; });
  return found != sets_.end() ? &*found : nullptr;
}

std::vector<std::string> EnSightCase::files_of(const NamedFile& file, double time) const {
  if (file.pattern.find('*') == std::string::npos) return {in_folder(file.pattern)};
  if (file.in_file_set) return all_matching(in_folder(file.pattern));
  const TimeSet* const set = time_set(file.time_set);
  if (set == nullptr || set->numbers.empty()) return {};
  const std::size_t step = std::min(set->step_at(time), set->numbers.size() - 1);
  return {in_folder(with_number(file.pattern, set->numbers[step]))};
}

std::vector<std::string> EnSightCase::files_at(double time) const {
  std::vector<std::string> files;
  for (const NamedFile& file : files_) {
    const std::vector<std::string> found = files_of(file, time);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::string EnSightCase::in_folder(const std::string& name) const {
  return (std::filesystem::path(folder_) / name).string();
}

std::string EnSightCase::fault_of_times() const {
  std::set<double> times;
  std::set<float> rounded;
  for (const TimeSet& set : sets_) {
    if (static_cast<std::size_t>(std::max(set.steps, 0)) != set.times.size()) {
      return "time set " + std::to_string(set.id) + " says " + std::to_string(set.steps) +
             " steps, and gives " + std::to_string(set.times.size()) + " times";
    }
    times.insert(set.times.begin(), set.times.end());
    for (const double time : set.times) rounded.insert(static_cast<float>(time));
  }
  if (rounded.size() < times.size()) {
    return "some times are the same in single precision, in which VTK takes them: give them from "
           "the first one on";
  }
  for (const NamedFile& file : files_) {
    const TimeSet* const set = time_set(file.time_set);
    if (file.pattern.find('*') == std::string::npos || file.in_file_set) continue;
    if (set != nullptr && static_cast<int>(set->numbers.size()) >= set->steps && set->steps > 0) {
      continue;
    }
    return in_folder(file.pattern) +
           " stands for a file of each step, and no time set of the case counts them (TIME)";
  }
  return "";
}

std::string EnSightCase::fault_of_marks(double time) const {
  if (!has_file_sets_) return "";
  for (const NamedFile& file : files_) {
    if (!file.in_file_set) {
      return in_folder(file.pattern) +
             " has no file set in this case, and others have: VTK's reader does not take both "
             "(leave the section FILE out, or give all of them a file set)";
    }
    // Several files share the steps: then each has its own first one.
    const bool has_all = file.pattern.find('*') == std::string::npos;
    const TimeSet* const set = time_set(file.time_set);
    const std::size_t before = has_all && set != nullptr ? set->step_at(time) : 0;
    for (const std::string& path : files_of(file, time)) {
      if (has_marks(path, "BEGIN TIME STEP", before + 1) &&
          has_marks(path, "END TIME STEP", before)) {
        continue;
      }
      return path + " has not the marks of " + std::to_string(before + 1) +
             " time steps, as this case says (BEGIN TIME STEP, END TIME STEP)";
    }
  }
  return "";
}

std::string EnSightCase::fault_of_counts(double time) const {
  const std::vector<std::string> files = files_at(time);
  if (files.empty()) return "";
  const MappedFile file = MappedFile::open(files.front());
  std::string_view rest(reinterpret_cast<const char*>(file.bytes().data()), file.size());
  if (!is_ensight_text(rest)) return "";
  std::string_view before;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (is_counted(before) && !is_count_of_lines(line, rest.size())) {
      return files.front() + " says that of '" + std::string(before) + "' there are " +
             std::string(line) + ", and has not so many lines: it is damaged or cut off";
    }
    before = line;
  }
  return "";
}

std::string EnSightCase::fault_of_lines(double time) const {
  if (!is_gold_ || has_file_sets_) return "";
  EnSightGold gold;
  for (const NamedFile& file : files_) {
    const std::uint64_t components = components_of(file.kind);
    if (file.kind != "model" && components == 0) continue;
    for (const std::string& path : files_of(file, time)) {
      const MappedFile mapped = MappedFile::open(path);
      const std::string_view text(reinterpret_cast<const char*>(mapped.bytes().data()),
                                  mapped.size());
      if (!is_ensight_text(text)) continue;
      const std::string fault =
          components == 0 ? gold.fault_of_geometry(text) : gold.fault_of_variable(text, components);
      if (!fault.empty()) return path + " " + fault;
    }
  }
  return "";
}

}  // namespace tetfusion
