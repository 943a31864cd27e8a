// Numbers as users write them: 90%, 0.9, 2.5M, 1G; and sizes in bytes. And as files do. None of
// these asks the host's locale.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace tetfusion {

std::optional<double> parse_number(std::string_view text);  // all of the text, or nothing; finite

// What a file's number is where std::from_chars() has found all of it out of the range of a T,
// float or double: infinite, or as near to 0 as a T comes.
template <class T>
T out_of_range_number(std::string_view text);
// A plus sign in front is none of what std::from_chars() knows; one before a minus sign stays.
inline std::string_view without_plus(std::string_view text) {
  const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  return has_plus ? text.substr(1) : text;
}
// What std::from_chars() does not take of floating-point numbers: out_of_range_number(), and
// Fortran's exponents (1.5D+02).
template <class T>
std::optional<T> odd_number(std::string_view text);
// A number as files have it, all of the text, or nothing.
template <class T>
std::optional<T> number_in(std::string_view text) {
  text = without_plus(text);
  T value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (stop == end && error == std::errc()) return value;
  if constexpr (std::is_floating_point_v<T>) return odd_number<T>(text);
  return std::nullopt;
}

std::optional<double> parse_share(std::string_view text);  // "0.5%" is 0.005, "0.005" too
bool is_bare_one(std::string_view text);  // "1": a share of all, though 1% may be what is meant
// Whole numbers: "1000000", "1M", "2.5k", "1G" (powers of 1000).
std::optional<std::uint64_t> parse_count(std::string_view text);
// Sizes: "512M", "1.5G", "2GiB", "4096" (bytes); K, M, G and T are powers of 1024. Parts of a byte
// are cut off.
std::optional<std::uint64_t> parse_bytes(std::string_view text);
std::vector<std::string> split(std::string_view text, char separator);
std::string_view trimmed(std::string_view text);  // without blanks and ends of lines at its ends

std::string format_count(std::uint64_t count);  // 1,499,160
// With what is counted: "1 point", "2,000 points", "1 vertex". Without `many` that is `one` with
// an s.
std::string format_count(std::uint64_t count, std::string_view one, std::string_view many = {});
std::string format_bytes(std::uint64_t bytes);  // 1.4 GiB
// As parse_bytes() takes it, rounded up to a whole MiB: 1434M.
std::string format_memory(std::uint64_t bytes);

}  // namespace tetfusion
