// Words and numbers in a text, separated by blanks, taken side by side: the text is cut into blocks
// at ends of lines, counted first, so that each token knows its number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/blocks.h"
#include "io/files/mapped_file.h"

namespace tetfusion {

inline bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// Goes through the tokens of a text. From `comment` (0: there are none) at the begin of a token to
// the end of the line nothing counts.
class TokenCursor {
 public:
  TokenCursor(std::string_view text, char comment)
      : at_(text.data()), end_(text.data() + text.size()), comment_(comment) {}

  // The next token; empty at the end.
  std::string_view next() {
    skip_blanks();
    const char* const begin = at_;
    while (at_ < end_ && !is_blank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  const char* at() const { return at_; }  // behind the last token

 private:
  void skip_blanks() {
    for (;;) {
      while (at_ < end_ && is_blank(*at_)) ++at_;
      if (at_ == end_ || comment_ == 0 || *at_ != comment_) return;
      while (at_ < end_ && *at_ != '\n') ++at_;
    }
  }

  const char* at_;
  const char* end_;
  char comment_;
};

// A text that lies in a file, whose pages do not stay in memory. Keeps 24 bytes for each MiB. Safe
// to use from several threads.
class TextTokens {
 public:
  TextTokens(const MappedFile& file, std::string_view text, char comment);

  std::uint64_t size() const { return first_.back(); }

  // Calls f(row, column, token) for the tokens of some rows, `columns` to a row: blocks of them
  // from several threads, within a block in order. Throws the lowest block's exception. The rows
  // are there.
  template <class F>
  void for_each(std::uint64_t columns, std::uint64_t first_row, std::uint64_t rows, F f) const {
    if (rows == 0) return;
    const std::uint64_t first = first_row * columns;
    const std::uint64_t last = first + rows * columns;
    const std::size_t begin = block_of(first);
    const std::size_t end = block_of(last - 1) + 1;
    for_each_block(end - begin, 1, [&](std::size_t i, std::size_t, std::size_t) {
      const std::string_view block = blocks_[begin + i];
      std::uint64_t number = first_[begin + i];
      TokenCursor cursor(block, comment_);
      std::string_view token = cursor.next();
      for (; number < first; ++number) token = cursor.next();
      std::uint64_t row = number / columns;
      std::uint64_t column = number % columns;
      for (; number < last && !token.empty(); token = cursor.next(), ++number) {
        f(row, column, token);
        if (++column < columns) continue;
        column = 0;
        ++row;
      }
      release(block);
    });
  }

  // The token of that number; empty behind the last one.
  std::string_view operator[](std::uint64_t index) const;

 private:
  // The last one that begins there: those without tokens have none of it.
  std::size_t block_of(std::uint64_t token) const;
  void release(std::string_view block) const;

  const MappedFile* file_;
  std::vector<std::string_view> blocks_;
  std::vector<std::uint64_t> first_;  // number of each block's first token, and of all
  char comment_;
};

// The text in pieces of about 1 MiB that end with a line.
std::vector<std::string_view> cut_at_lines(std::string_view text);

// All tokens that begin with a letter, but for nan and inf, in order. The pages of the text do not
// stay in memory.
std::vector<std::string_view> find_words(const MappedFile& file, std::string_view text,
                                         char comment);

}  // namespace tetfusion
