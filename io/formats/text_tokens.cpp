#include "io/formats/text_tokens.h"

#include <algorithm>
#include <array>

namespace tetfusion {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool is_not_finite(std::string_view token) {
  constexpr std::array<std::string_view, 3> kWords{"nan", "inf", "infinity"};
  return std::any_of(kWords.begin(), kWords.end(), [&](std::string_view word) {
    return token.size() == word.size() &&
           std::equal(token.begin(), token.end(), word.begin(),
                      [](char a, char b) { return (a | 0x20) == b; });
  });
}

void release_text(const MappedFile& file, std::string_view text) {
  const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
  file.dont_need_around(static_cast<std::uint64_t>(begin - file.bytes().data()), text.size());
}

std::uint64_t count_tokens(std::string_view text, char comment) {
  TokenCursor cursor(text, comment);
  std::uint64_t count = 0;
  while (!cursor.next().empty()) ++count;
  return count;
}

}  // namespace

std::vector<std::string_view> cut_at_lines(std::string_view text) {
  std::vector<std::string_view> blocks;
  while (!text.empty()) {
    const std::size_t end = text.size() <= kBlockBytes ? text.npos : text.find('\n', kBlockBytes);
    const std::size_t bytes = end == text.npos ? text.size() : end + 1;
    blocks.push_back(text.substr(0, bytes));
    text.remove_prefix(bytes);
  }
  return blocks;
}

TextTokens::TextTokens(const MappedFile& file, std::string_view text, char comment)
    : file_(&file), blocks_(cut_at_lines(text)), first_(blocks_.size() + 1), comment_(comment) {
  for_each_block(blocks_.size(), 1, [&](std::size_t b, std::size_t, std::size_t) {
    first_[b + 1] = count_tokens(blocks_[b], comment_);
    release(blocks_[b]);
  });
  for (std::size_t b = 0; b < blocks_.size(); ++b) first_[b + 1] += first_[b];
}

std::size_t TextTokens::block_of(std::uint64_t token) const {
  const auto after = std::upper_bound(first_.begin(), first_.end(), token);
  return static_cast<std::size_t>(after - first_.begin()) - 1;
}

void TextTokens::release(std::string_view block) const { release_text(*file_, block); }

std::string_view TextTokens::operator[](std::uint64_t index) const {
  if (index >= size()) return {};
  const std::size_t b = block_of(index);
  TokenCursor cursor(blocks_[b], comment_);
  for (std::uint64_t i = first_[b]; i < index; ++i) cursor.next();
  return cursor.next();
}

std::vector<std::string_view> find_words(const MappedFile& file, std::string_view text,
                                         char comment) {
  const std::vector<std::string_view> blocks = cut_at_lines(text);
  std::vector<std::vector<std::string_view>> found(blocks.size());
  for_each_block(blocks.size(), 1, [&](std::size_t b, std::size_t, std::size_t) {
    TokenCursor cursor(blocks[b], comment);
    for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
      if (is_letter(token[0]) && !is_not_finite(token)) found[b].push_back(token);
    }
    release_text(file, blocks[b]);
  });
  std::vector<std::string_view> words;
  for (const auto& of_block : found) words.insert(words.end(), of_block.begin(), of_block.end());
  return words;
}

}  // namespace tetfusion
