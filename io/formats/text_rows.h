// Rows of numbers as text, put together by several threads and written in order.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "base/blocks.h"
#include "io/files/output_file.h"

namespace tetfusion {

// Numbers with blanks between them; floating-point ones in as few digits as give the same value
// back.
class TextRow {
 public:
  template <class T>
  TextRow& add(T value) {
    static_assert(std::is_arithmetic_v<T> && sizeof(T) > 1);
    // The sign of a NaN is not a number's; "-nan" would stop some readers.
    if constexpr (std::is_floating_point_v<T>) {
      if (std::isnan(value)) value = std::abs(value);
    }
    char digits[32];
    const std::to_chars_result result = std::to_chars(digits, digits + sizeof digits, value);
    if (!text_.empty() && text_.back() != '\n') text_ += ' ';
    text_.append(digits, static_cast<std::size_t>(result.ptr - digits));
    return *this;
  }
  void end() { text_ += '\n'; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Calls f(i, &row) for i = 0 .. rows - 1, each of which adds its numbers.
template <class F>
void put_text_rows(std::size_t rows, OutputFile* file, F f) {
  constexpr std::size_t kRowsPerBlock = 8192;
  std::vector<TextRow> blocks(block_count(rows, kRowsPerBlock));
  for_each_block(rows, kRowsPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      f(i, &blocks[b]);
      blocks[b].end();
    }
  });
  for (const TextRow& block : blocks) file->append(block.text().data(), block.text().size());
}

inline void put_text(const std::string& text, OutputFile* file) {
  file->append(text.data(), text.size());
}

}  // namespace tetfusion
