#include "io/formats/format_file.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>
#include <type_traits>

#include "base/numbers.h"

namespace tetfusion {

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
  if (const std::optional<T> value = number_in<T>(token)) return *value;
  if constexpr (std::is_floating_point_v<T>) {
    fail_in_line(token.data(), "expected a number, found " + quoted(token));
  } else {
    const std::string_view digits = without_plus(token);
    T value{};
    const char* const end = digits.data() + digits.size();
    if (std::from_chars(digits.data(), end, value).ec == std::errc::result_out_of_range) {
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
