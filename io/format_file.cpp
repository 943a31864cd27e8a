#include "io/format_file.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>
#include <type_traits>

#include "base/numbers.h"

namespace tetfusion {

namespace {

template <class T>
std::from_chars_result parse(std::string_view token, T* value) {
  return std::from_chars(token.data(), token.data() + token.size(), *value);
}

// What std::from_chars() does not take: numbers that round to zero or infinity, and Fortran's
// exponents (1.5D+02).
template <class T>
bool parse_odd(std::string_view token, T* value) {
  std::string text(token);
  std::replace(text.begin(), text.end(), 'd', 'e');
  std::replace(text.begin(), text.end(), 'D', 'e');
  const std::from_chars_result result = parse(std::string_view(text), value);
  if (result.ptr != text.data() + text.size()) return false;
  if (result.ec == std::errc::result_out_of_range) {
    *value = out_of_range_number<T>(text);
    return true;
  }
  return result.ec == std::errc();
}

}  // namespace

std::string quoted(std::string_view text) {
  constexpr std::size_t kMost = 24;
  std::string out = "'";
  for (const char c : text.substr(0, kMost)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > kMost ? "...'" : "'");
}

std::string FormatFile::line_of(const char* at) const {
  const char* const begin = text().data();
  return "line " + std::to_string(1 + std::count(begin, at, '\n'));
}

std::string FormatFile::byte_of(const void* at) const {
  return "byte " + std::to_string(static_cast<const std::byte*>(at) - file.bytes().data());
}

void FormatFile::fail(ErrorCode code, const std::string& what) const {
  throw Error(code, file.path() + ": " + what);
}

void FormatFile::fail_in_line(const char* at, const std::string& what) const {
  fail(line_of(at) + ": " + what);
}

void FormatFile::fail_at_byte(const void* at, const std::string& what) const {
  fail(byte_of(at) + ": " + what);
}

void FormatFile::invalid_in_line(const char* at, const std::string& what) const {
  throw InvalidMesh(file.path() + ": " + line_of(at) + ": " + what);
}

void FormatFile::invalid_at_byte(const void* at, const std::string& what) const {
  throw InvalidMesh(file.path() + ": " + byte_of(at) + ": " + what);
}

template <class T>
T FormatFile::number(std::string_view token) const {
  std::string_view digits = token;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  T value{};
  const std::from_chars_result result = parse(digits, &value);
  if (result.ec == std::errc() && result.ptr == digits.data() + digits.size()) return value;
  if constexpr (std::is_floating_point_v<T>) {
    if (parse_odd(digits, &value)) return value;
    fail_in_line(token.data(), "expected a number, found " + quoted(token));
  } else {
    if (result.ec == std::errc::result_out_of_range) {
      fail_in_line(token.data(), quoted(token) + " is too large or too small: expected " +
                                     std::to_string(std::numeric_limits<T>::min()) + " to " +
                                     std::to_string(std::numeric_limits<T>::max()));
    }
    fail_in_line(token.data(), "expected a whole number, found " + quoted(token));
  }
}

template float FormatFile::number(std::string_view) const;
template double FormatFile::number(std::string_view) const;
template std::int32_t FormatFile::number(std::string_view) const;
template std::int64_t FormatFile::number(std::string_view) const;
template std::uint64_t FormatFile::number(std::string_view) const;

}  // namespace tetfusion
