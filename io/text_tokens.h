// Words and numbers in a text, separated by blanks, taken side by side: the text is cut into blocks
// at ends of lines, counted first, so that each token knows its number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/vector.h"
#include "mesh/blocks.h"

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

class TextTokens {
 public:
  TextTokens(std::string_view text, char comment);

  std::uint64_t size() const { return first_.back(); }

  // Calls f(row, column, token) for all tokens, `columns` to a row: blocks of them from several
  // threads, within a block in order. Throws the lowest block's exception.
  template <class F>
  void for_each(std::uint64_t columns, F f) const {
    for_each_block(blocks_.size(), 1, [&](std::size_t b, std::size_t, std::size_t) {
      std::uint64_t row = first_[b] / columns;
      std::uint64_t column = first_[b] % columns;
      TokenCursor cursor(blocks_[b], comment_);
      for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
        f(row, column, token);
        if (++column < columns) continue;
        column = 0;
        ++row;
      }
    });
  }

  // The token of that number; empty behind the last one.
  std::string_view operator[](std::uint64_t index) const;

 private:
  std::vector<std::string_view> blocks_;
  std::vector<std::uint64_t> first_;  // number of each block's first token, and of all
  char comment_;
};

// The text in pieces of about 1 MiB that end with a line.
std::vector<std::string_view> cut_at_lines(std::string_view text);

// All tokens that begin with a letter, but for nan and inf, in order.
std::vector<std::string_view> find_words(std::string_view text, char comment);

}  // namespace tetfusion
