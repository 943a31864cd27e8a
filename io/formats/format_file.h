// A file of a format that other programs made: its bytes, and messages that say where in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "io/files/mapped_file.h"

namespace tetfusion {

struct FormatFile {
  MappedFile file;

  std::string_view text() const {
    return {reinterpret_cast<const char*>(file.bytes().data()), file.size()};
  }

  // Takes the pages of a part of text() out of memory.
  void release(const char* begin, const char* end) const {
    file.dont_need_around(static_cast<std::uint64_t>(begin - text().data()),
                          static_cast<std::uint64_t>(end - begin));
  }
  void release(std::string_view part) const { release(part.data(), part.data() + part.size()); }

  // "data.mesh: what". The others name a place before it: a line, counted from 1, or a byte.
  [[noreturn]] void fail(ErrorCode code, const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const { fail(ErrorCode::kBadInput, what); }
  [[noreturn]] void fail_in_line(const char* at, const std::string& what) const;
  [[noreturn]] void fail_at_byte(const void* at, const std::string& what) const;
  // As fail_in_line() and fail_at_byte(), for what makes the mesh none.
  [[noreturn]] void invalid_in_line(const char* at, const std::string& what) const;
  [[noreturn]] void invalid_at_byte(const void* at, const std::string& what) const;

  // `at` lies in text() or is its end.
  std::string line_of(const char* at) const;  // "line 7"
  std::string byte_of(const void* at) const;  // "byte 1024"

  // The whole token as a number; of a whole number all bits fit. Fails, naming the line.
  template <class T>
  T number(std::string_view token) const;
};

extern template float FormatFile::number(std::string_view) const;
extern template double FormatFile::number(std::string_view) const;
extern template std::int32_t FormatFile::number(std::string_view) const;
extern template std::int64_t FormatFile::number(std::string_view) const;
extern template std::uint64_t FormatFile::number(std::string_view) const;

// What a message may quote of a file: its first characters, printable.
std::string quoted(std::string_view text);

}  // namespace tetfusion
