#include "base/numbers.h"

#include <fmt/format.h>
#include <locale.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace tetfusion {

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

template <class T>
T out_of_range_number(std::string_view text) {
  // A host's own locale may want a comma, and end the number at its point.
  static const locale_t plain = newlocale(LC_ALL_MASK, "C", nullptr);
  return static_cast<T>(strtod_l(std::string(text).c_str(), nullptr, plain));
}

template float out_of_range_number(std::string_view text);
template double out_of_range_number(std::string_view text);

template <class T>
std::optional<T> odd_number(std::string_view text) {
  std::string plain(text);
  std::replace(plain.begin(), plain.end(), 'd', 'e');
  std::replace(plain.begin(), plain.end(), 'D', 'e');
  T value{};
  const char* const end = plain.data() + plain.size();
  const auto [stop, error] = std::from_chars(plain.data(), end, value);
  if (stop != end) return std::nullopt;
  if (error == std::errc::result_out_of_range) return out_of_range_number<T>(plain);
  return error == std::errc() ? std::optional<T>(value) : std::nullopt;
}

template std::optional<float> odd_number(std::string_view text);
template std::optional<double> odd_number(std::string_view text);

std::optional<double> parse_share(std::string_view text) {
  const bool percent = text.ends_with('%');
  if (percent) text.remove_suffix(1);
  const auto value = parse_number(text);
  if (value && percent) return *value / 100;
  return value;
}

bool is_bare_one(std::string_view text) { return parse_number(text) == 1.0; }

namespace {

// k, m, g, t in either case are 1 to 4; 0 for anything else.
int power_of_unit(char unit) {
  switch (unit) {
    case 'k':
    case 'K':
      return 1;
    case 'm':
    case 'M':
      return 2;
    case 'g':
    case 'G':
      return 3;
    case 't':
    case 'T':
      return 4;
    default:
      return 0;
  }
}

constexpr double kLargestWhole = 9007199254740992.0;  // 2^53: whole numbers below are exact

}  // namespace

std::optional<std::uint64_t> parse_count(std::string_view text) {
  const int power = text.empty() ? 0 : power_of_unit(text.back());
  if (power > 3) return std::nullopt;
  if (power > 0) text.remove_suffix(1);
  const auto value = parse_number(text);
  if (!value) return std::nullopt;
  const double count = *value * std::pow(1000.0, power);
  if (!(count >= 0) || count > kLargestWhole) return std::nullopt;
  // 4.1 is not quite what its double is: times a million, it is one ulp off.
  const double whole = std::round(count);
  if (std::abs(count - whole) > 1e-15 * whole) return std::nullopt;
  return static_cast<std::uint64_t>(whole);
}

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  const bool binary = text.ends_with("iB");
  if (binary) text.remove_suffix(2);
  const int power = text.empty() ? 0 : power_of_unit(text.back());
  if (power > 0) text.remove_suffix(1);
  const auto value = parse_number(text);
  if (!value || !(*value >= 0) || (binary && power == 0)) return std::nullopt;
  if (power == 0 && *value != std::floor(*value)) return std::nullopt;
  const double bytes = std::floor(std::ldexp(*value, 10 * power));
  if (bytes > kLargestWhole) return std::nullopt;
  return static_cast<std::uint64_t>(bytes);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    parts.emplace_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

std::string format_count(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, 1, ',');
  return digits;
}

std::string format_count(std::uint64_t count, std::string_view one, std::string_view many) {
  const std::string number = format_count(count);
  if (count == 1) return fmt::format("{} {}", number, one);
  return many.empty() ? fmt::format("{} {}s", number, one) : fmt::format("{} {}", number, many);
}

std::string format_bytes(std::uint64_t bytes) {
  constexpr std::array<const char*, 5> kUnits{"bytes", "KiB", "MiB", "GiB", "TiB"};
  auto value = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (value >= 1024 && unit + 1 < kUnits.size()) {
    value /= 1024;
    ++unit;
  }
  return unit == 0 ? format_count(bytes, "byte") : fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string format_memory(std::uint64_t bytes) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  return fmt::format("{}M", bytes / kMiB + (bytes % kMiB != 0 ? 1 : 0));
}

}  // namespace tetfusion
