#include "io/vtk/legacy_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>

#include "base/error.h"
#include "base/numbers.h"
#include "io/formats/format_file.h"
#include "io/formats/text_tokens.h"
#include "io/vtk/legacy_arrays.h"

namespace tetfusion {

namespace {

// A number takes a digit and a blank.
constexpr std::uint64_t kLeastTextBytes = 2;

// A type by VTK's name, and by how many bytes a value has in a binary file.
struct LegacyType {
  std::string_view name;
  ValueType type;
};
constexpr std::array<LegacyType, 23> kTypes = {{{"unsigned_char", ValueType::kUInt8},
                                                {"char", ValueType::kInt8},
                                                {"signed_char", ValueType::kInt8},
                                                {"unsigned_short", ValueType::kUInt16},
                                                {"short", ValueType::kInt16},
                                                {"unsigned_int", ValueType::kUInt32},
                                                {"int", ValueType::kInt32},
                                                {"vtkidtype", ValueType::kInt32},
                                                {"unsigned_long", ValueType::kUInt64},
                                                {"long", ValueType::kInt64},
                                                {"unsigned_long_long", ValueType::kUInt64},
                                                {"long_long", ValueType::kInt64},
                                                {"vtktypeuint8", ValueType::kUInt8},
                                                {"vtktypeint8", ValueType::kInt8},
                                                {"vtktypeuint16", ValueType::kUInt16},
                                                {"vtktypeint16", ValueType::kInt16},
                                                {"vtktypeuint32", ValueType::kUInt32},
                                                {"vtktypeint32", ValueType::kInt32},
                                                {"vtktypeuint64", ValueType::kUInt64},
                                                {"vtktypeint64", ValueType::kInt64},
                                                {"float", ValueType::kFloat32},
                                                {"double", ValueType::kFloat64},
                                                {"bit", ValueType::kUInt8}}};

std::string_view text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.size()};
}

const LegacyType* find_type(std::string_view word) {
  const std::string small = in_small_letters(word);
  const auto at = std::find_if(kTypes.begin(), kTypes.end(),
                               [&](const LegacyType& type) { return type.name == small; });
  return at == kTypes.end() ? nullptr : &*at;
}

}  // namespace

std::string in_capitals(std::string_view word) {
  std::string out(word);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return out;
}

std::string in_small_letters(std::string_view word) {
  std::string out(word);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned code = 0;
    const char* const digits = text.data() + i + 1;
    if (text[i] == '%' && text.size() - i > 2 &&
        std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
      out += static_cast<char>(code);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string joined(const std::vector<std::string_view>& words) {
  std::string line;
  for (const std::string_view word : words) line.append(line.empty() ? "" : " ").append(word);
  return line;
}

LegacyText::LegacyText(const MappedFile& file) : file_(file), text_(text_of(file)) {}

void LegacyText::release() const { file_.dont_need_around(released_, text_.size() - released_); }

void LegacyText::fail(const std::string& what) const {
  throw Error(ErrorCode::kBadInput, file_.path() + ": " + what);
}
void LegacyText::fail_at(std::size_t at, const std::string& what) const {
  at = std::min(at, text_.size());
  if (binary_) fail("byte " + std::to_string(at) + ": " + what);
  const auto end = text_.begin() + static_cast<std::ptrdiff_t>(at);
  fail("line " + std::to_string(1 + std::count(text_.begin(), end, '\n')) + ": " + what);
}

void LegacyText::skip_blanks() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
}
void LegacyText::skip_to_keyword() {
  skip_blanks();
  while (at_ < text_.size() && text_[at_] == kLegacyComment) {
    take_line();
    skip_blanks();
  }
}

std::string_view LegacyText::take_line() {
  const std::size_t end = std::min(text_.find('\n', at_), text_.size());
  std::string_view line = text_.substr(at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::vector<std::string_view> LegacyText::take_words() {
  std::vector<std::string_view> words;
  TokenCursor cursor(take_line(), 0);
  for (std::string_view word = cursor.next(); !word.empty(); word = cursor.next()) {
    words.push_back(word);
  }
  return words;
}

bool LegacyText::comes(std::string_view word) const {
  const std::string_view next = text_.substr(at_, word.size());
  const std::size_t end = at_ + word.size();
  return in_capitals(next) == word && (end >= text_.size() || is_blank(text_[end]));
}

void LegacyText::expect_words(const std::vector<std::string_view>& words, std::size_t count,
                              const char* form) const {
  if (words.size() >= count) return;
  fail_at(words.empty() ? at_ : place_of(words[0]),
          "expected " + std::string(form) + ", found " + quoted(joined(words)));
}

std::uint64_t LegacyText::count_of(std::string_view word) const {
  const auto count = number_in<std::uint64_t>(word);
  if (!count) fail_at(place_of(word), "expected a count, found " + quoted(word));
  return *count;
}

VtuArray LegacyText::take_values(const std::string& name, std::string_view type_word,
                                 std::uint64_t rows, std::uint64_t components) {
  const LegacyType* const found = find_type(type_word);
  if (found == nullptr) {
    fail_at(at_, name + ": arrays of type " + quoted(type_word) +
                     " cannot be read, only those of VTK's integers, float and double");
  }
  const LegacyType& type = *found;
  const bool bits = binary_ && type.name == "bit";
  VtuArray array;
  array.present = true;
  if (components == 0 || components > std::numeric_limits<std::uint32_t>::max()) {
    fail_at(at_, name + ": " + std::to_string(components) + " components cannot be read");
  }
  array.info = {name, type.type, static_cast<std::uint32_t>(components), {}, rows};
  const std::uint64_t left = text_.size() - at_;
  std::uint64_t values = 0;
  std::uint64_t bytes = 0;
  const bool too_large =
      __builtin_mul_overflow(rows, components, &values) ||
      (binary_ ? __builtin_mul_overflow(values, size_of(type.type), &bytes) : values > left);
  if (bits) bytes = values / 8 + (values % 8 == 0 ? 0 : 1);
  if (too_large || bytes > left || (!binary_ && values > left / kLeastTextBytes + 1)) {
    fail_at(at_, name + ": " + std::to_string(rows) + " rows of " + std::to_string(components) +
                     " values do not fit into the " + std::to_string(left) +
                     " bytes that follow: the file is cut off or damaged");
  }
  if (!binary_) {
    array.payload = {Coding::kAscii, false, at_, skip_numbers(name, values)};
    return array;
  }
  array.payload = {Coding::kRaw, false, at_, at_ + bytes};
  if (bits) array.computed = bits_of(file_, at_, values);
  at_ += bytes;
  return array;
}

// Goes behind so many numbers. Returns where that is.
std::size_t LegacyText::skip_numbers(const std::string& name, std::uint64_t count) {
  constexpr std::size_t kReleased = std::size_t{1} << 20;
  const std::size_t begin = at_;
  for (std::uint64_t i = 0; i < count; ++i) {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    if (at_ == text_.size() || !begins_number(at_)) {
      fail_at(at_,
              name + ": expected " + format_count(count, "number") + ", found " + format_count(i));
    }
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    if (at_ - released_ < kReleased) continue;
    file_.dont_need(released_, at_ - released_);
    released_ = at_;
  }
  if (begin < released_) file_.dont_need_around(begin, released_ - begin);
  return at_;
}

// Or nan, inf; what is neither is refused when it is read.
bool LegacyText::begins_number(std::size_t at) const {
  const char c = text_[at];
  if (c <= '9') return true;
  const char small = static_cast<char>(c | 0x20);
  if (small != 'n' && small != 'i') return false;
  const std::string word = in_small_letters(text_.substr(at, 3));
  return word == "nan" || word == "inf";
}

void LegacyText::take_strings(const std::string& name, std::uint64_t rows, std::uint64_t components,
                              Vector<std::byte>* bytes) {
  std::uint64_t count = 0;
  if (__builtin_mul_overflow(rows, components, &count) || count > text_.size() - at_ + 1) {
    fail_at(at_, name + ": so many strings do not fit into the file");
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string text = binary_ ? take_binary_string(name) : decoded(take_line());
    if (bytes == nullptr) continue;
    for (const char c : text) bytes->push_back(static_cast<std::byte>(c));
    bytes->push_back(std::byte{0});
  }
}

// Its length first: 6, 14, 30 or 62 bits of it, behind two that say which.
std::string LegacyText::take_binary_string(const std::string& name) {
  const auto byte = [&](std::size_t i) {
    if (at_ + i >= text_.size()) fail_at(at_, name + ": the file ends within a string");
    return static_cast<unsigned char>(text_[at_ + i]);
  };
  const std::size_t width = std::size_t{8} >> (byte(0) >> 6);
  std::uint64_t length = byte(0) & 0x3Fu;
  for (std::size_t i = 1; i < width; ++i) length = length << 8 | byte(i);
  at_ += width;
  if (length > text_.size() - at_) fail_at(at_, name + ": the file ends within a string");
  std::string out(text_.substr(at_, length));
  at_ += length;
  return out;
}

}  // namespace tetfusion
