#include "series/step_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <set>

#include "base/numbers.h"

namespace tetfusion {

namespace {

// Of a letter in UTF-8, but for its first byte.
bool goes_on(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

struct Part {
  std::size_t begin, end;
};

// The numbers in a name. Where a letter stands before it, a number has no sign and no exponent, nor
// digits behind a point unless it is 0: part2.0010 is number 10 of part 2.
std::vector<Part> numbers_in(const std::string& name) {
  std::vector<Part> numbers;
  const auto digits_from = [&](std::size_t at) {
    while (at < name.size() && is_digit(name[at])) ++at;
    return at;
  };
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  for (std::size_t at = 0; at < name.size();) {
    if (!is_digit(name[at])) {
      ++at;
      continue;
    }
    Part number{at, digits_from(at)};
    const bool is_zero = number.end == at + 1 && name[at] == '0';
    const bool is_alone =
        at == 0 || (!is_word(name[at - 1]) &&
                    (name[at - 1] != '.' || numbers.empty() || numbers.back().end + 1 != at));
    if (is_alone || is_zero) {
      const std::size_t after_point = digits_from(number.end + 1);
      if (number.end < name.size() && name[number.end] == '.' && after_point > number.end + 1) {
        number.end = after_point;
      }
    }
    if (is_alone) {
      std::size_t exponent = number.end + 1;
      if (exponent < name.size() && (name[exponent] == '-' || name[exponent] == '+')) ++exponent;
      const bool has_e = number.end < name.size() && (name[number.end] | 0x20) == 'e';
      if (has_e && digits_from(exponent) > exponent) number.end = digits_from(exponent);
      const bool has_sign = at > 0 && name[at - 1] == '-';
      if (has_sign && (at == 1 || !is_word(name[at - 2]))) --number.begin;
    }
    numbers.push_back(number);
    at = number.end;
  }
  return numbers;
}

std::string last_number(const std::string& name) {
  const std::vector<Part> numbers = numbers_in(name);
  if (numbers.empty()) return "";
  return name.substr(numbers.back().begin, numbers.back().end - numbers.back().begin);
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
  for (const std::string& name : names) {
    for (const Part& number : numbers_in(name)) {
      const std::size_t from_end = name.size() - number.end;
      if (number.begin < begin && begin <= number.end) begin = number.begin;
      if (from_end < end && end <= name.size() - number.begin) end = from_end;
    }
  }
  const std::string& any = names[0];
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

// The files' names, or where these are all the same those of their folders.
std::vector<std::string> names_that_differ(const std::vector<std::string>& paths) {
  std::vector<std::filesystem::path> files(paths.begin(), paths.end());
  std::vector<std::string> own;
  while (true) {
    std::vector<std::string> names;
    for (const auto& file : files) names.push_back(file.filename().string());
    if (own.empty()) own = names;
    if (std::set<std::string>(names.begin(), names.end()).size() > 1) return names;
    for (auto& file : files) {
      if (!file.has_relative_path()) return own;
      file = file.parent_path();
    }
  }
}

}  // namespace

std::vector<std::string> label_steps(const std::vector<std::string>& paths) {
  std::vector<std::string> names = names_that_differ(paths);
  std::vector<std::string> labels =
      names.size() == 1 ? std::vector{last_number(std::filesystem::path(names[0]).stem().string())}
                        : differences(names);
  const std::set<std::string> different(labels.begin(), labels.end());
  if (different.size() == labels.size() && !different.contains("")) return labels;
  for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = count_label(i, labels.size());
  return labels;
}

std::string count_label(std::size_t i, std::size_t all) {
  return fmt::format("{:0{}}", i, std::to_string(all - 1).size());
}

bool is_number_label(const std::string& label) { return parse_number(label).has_value(); }

std::pair<double, std::uint64_t> number_in(const std::string& label) {
  std::uint64_t whole = 0;
  const char* const end = label.data() + label.size();
  const auto read = std::from_chars(label.data(), end, whole);
  return {*parse_number(label), read.ec == std::errc() && read.ptr == end ? whole : 0};
}

}  // namespace tetfusion
