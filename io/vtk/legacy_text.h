// A legacy .vtk file as it is walked through, once: its lines and words, and the values between
// them, which are not read, but measured. Messages name the line, in binary files the byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/vector.h"
#include "io/files/mapped_file.h"
#include "io/vtk/vtu_head.h"

namespace tetfusion {

inline constexpr char kLegacyComment = '#';

std::string in_capitals(std::string_view word);
std::string in_small_letters(std::string_view word);
// Names and strings of texts: %20 is a blank.
std::string decoded(std::string_view text);
std::string joined(const std::vector<std::string_view>& words);

// Everything throws Error(kBadInput) where the file has something else. The file outlives this, the
// views that it gives, and arrays.
class LegacyText {
 public:
  explicit LegacyText(const MappedFile& file);

  bool binary() const { return binary_; }
  void set_binary(bool binary) { binary_ = binary; }
  bool at_end() const { return at_ == text_.size(); }
  std::size_t at() const { return at_; }
  std::string_view part(std::size_t begin, std::size_t end) const {
    return text_.substr(begin, end - begin);
  }
  std::size_t place_of(std::string_view part) const {
    return static_cast<std::size_t>(part.data() - text_.data());
  }
  // Lets go of pages that are still held.
  void release() const;

  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const;

  // ---- lines and words ----

  void skip_blanks();
  void skip_to_keyword();  // comments, too
  // The rest of the line, and its end.
  std::string_view take_line();
  std::vector<std::string_view> take_words();
  // Is that the next word, in letters of either size?
  bool comes(std::string_view word) const;
  // What `words` say, as in "POINTS 8 float".
  void expect_words(const std::vector<std::string_view>& words, std::size_t count,
                    const char* form) const;
  std::uint64_t count_of(std::string_view word) const;

  // ---- values ----

  // An array of rows * components values of a type by VTK's name, which begin here.
  VtuArray take_values(const std::string& name, std::string_view type, std::uint64_t rows,
                       std::uint64_t components);
  // Appends so many strings, each with a zero at its end; null: passes over them.
  void take_strings(const std::string& name, std::uint64_t rows, std::uint64_t components,
                    Vector<std::byte>* bytes);

 private:
  std::size_t skip_numbers(const std::string& name, std::uint64_t count);
  bool begins_number(std::size_t at) const;
  std::string take_binary_string(const std::string& name);

  const MappedFile& file_;
  std::string_view text_;
  std::size_t released_ = 0;  // pages before it are not held
  std::size_t at_ = 0;
  bool binary_ = false;
};

}  // namespace tetfusion
