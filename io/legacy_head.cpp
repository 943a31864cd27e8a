#include "io/legacy_head.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <limits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/counted_cells.h"
#include "io/format_file.h"
#include "io/legacy_arrays.h"
#include "io/text_tokens.h"

namespace tetfusion {

namespace {

constexpr std::string_view kMagic = "# vtk DataFile Version";
constexpr char kComment = '#';
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

// What stands before an array of an attribute that is active: NAME TYPE and values of so many
// components, or the number of these (0) in the same line.
struct AttributeWord {
  std::string_view word;
  const char* active;  // VTK's name of it
  std::uint32_t components;
};
constexpr std::array<AttributeWord, 8> kAttributes = {{{"VECTORS", "Vectors", 3},
                                                       {"NORMALS", "Normals", 3},
                                                       {"TENSORS", "Tensors", 9},
                                                       {"TENSORS6", "Tensors", 6},
                                                       {"TEXTURE_COORDINATES", "TCoords", 0},
                                                       {"GLOBAL_IDS", "GlobalIds", 1},
                                                       {"PEDIGREE_IDS", "PedigreeIds", 1},
                                                       {"EDGE_FLAGS", "EdgeFlag", 1}}};

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

// Names and strings of texts: %20 is a blank.
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

std::string_view trimmed(std::string_view line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return line;
}

std::string_view text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.size()};
}

class LegacyParser {
 public:
  explicit LegacyParser(const MappedFile& file)
      : file_(file), text_(text_of(file)), released_(0), at_(0) {}

  VtuHead run() {
    parse_first_lines();
    for (skip_to_keyword(); at_ < text_.size(); skip_to_keyword()) parse_section();
    if (!piece_.coordinates.present) fail("there are no POINTS");
    if (!piece_.connectivity.present) fail("there are no CELLS");
    if (!piece_.types.present) fail("there are no CELL_TYPES");
    file_.dont_need_around(released_, text_.size() - released_);
    if (piece_.points == 0) piece_.point_data.clear();
    for (const VtuArray& a : piece_.point_data) head_.point_data.arrays.push_back(a.info);
    for (const VtuArray& a : piece_.cell_data) head_.cell_data.arrays.push_back(a.info);
    head_.pieces.push_back(std::move(piece_));
    describe_format();
    return std::move(head_);
  }

 private:
  enum class Place { kField, kPoints, kCells };

  // ---- messages ----

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, file_.path() + ": " + what);
  }
  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const {
    at = std::min(at, text_.size());
    if (binary_) fail("byte " + std::to_string(at) + ": " + what);
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(at);
    fail("line " + std::to_string(1 + std::count(text_.begin(), end, '\n')) + ": " + what);
  }
  std::size_t place_of(std::string_view part) const {
    return static_cast<std::size_t>(part.data() - text_.data());
  }

  // ---- lines and words ----

  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  void skip_to_keyword() {
    skip_blanks();
    while (at_ < text_.size() && text_[at_] == kComment) {
      take_line();
      skip_blanks();
    }
  }

  // The rest of the line, and its end.
  std::string_view take_line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  std::vector<std::string_view> take_words() {
    std::vector<std::string_view> words;
    TokenCursor cursor(take_line(), 0);
    for (std::string_view word = cursor.next(); !word.empty(); word = cursor.next()) {
      words.push_back(word);
    }
    return words;
  }

  // Is that the next word, in letters of either size?
  bool comes(std::string_view word) const {
    const std::string_view next = text_.substr(at_, word.size());
    const std::size_t end = at_ + word.size();
    return in_capitals(next) == word && (end >= text_.size() || is_blank(text_[end]));
  }

  // What `words` say, as in "POINTS 8 float".
  void expect_words(const std::vector<std::string_view>& words, std::size_t count,
                    const char* form) const {
    if (words.size() >= count) return;
    fail_at(words.empty() ? at_ : place_of(words[0]),
            "expected " + std::string(form) + ", found " + quoted(joined(words)));
  }
  static std::string joined(const std::vector<std::string_view>& words) {
    std::string line;
    for (const std::string_view word : words) line.append(line.empty() ? "" : " ").append(word);
    return line;
  }

  std::uint64_t count_of(std::string_view word) const {
    std::uint64_t count = 0;
    const char* const end = word.data() + word.size();
    const std::from_chars_result result = std::from_chars(word.data(), end, count);
    if (result.ec != std::errc() || result.ptr != end) {
      fail_at(place_of(word), "expected a count, found " + quoted(word));
    }
    return count;
  }

  // ---- the first lines ----

  void parse_first_lines() {
    if (!text_.starts_with(kMagic)) {
      fail("expected a first line \"" + std::string(kMagic) + " 5.1\", as legacy .vtk files have");
    }
    const std::string_view line = take_line();
    version_ = std::string(trimmed(line.substr(kMagic.size())));
    const auto [stop, error] =
        std::from_chars(version_.data(), version_.data() + version_.size(), major_);
    if (error != std::errc() || major_ < 1 || major_ > 5) {
      fail("line 1: version " + quoted(version_) +
           " is not known, expected 1.0 to 5.1: VTK's writer makes one of 4.2 with "
           "SetFileVersion(42)");
    }
    take_line();
    skip_to_keyword();
    const std::string kind = in_capitals(trimmed(take_line()));
    if (kind != "ASCII" && kind != "BINARY") {
      fail("line 3: expected ASCII or BINARY, found " + quoted(kind));
    }
    binary_ = kind == "BINARY";
    head_.layout = {Compressor::kNone, 0, std::endian::native == std::endian::little};
    skip_to_keyword();
    const std::size_t begin = at_;
    const std::vector<std::string_view> words = take_words();
    if (words.size() < 2 || in_capitals(words[0]) != "DATASET" ||
        in_capitals(words[1]) != "UNSTRUCTURED_GRID") {
      fail_at(begin, "expected DATASET UNSTRUCTURED_GRID, found " + quoted(joined(words)));
    }
  }

  // ---- sections ----

  void parse_section() {
    const std::size_t begin = at_;
    const std::vector<std::string_view> words = take_words();
    const std::string keyword = in_capitals(words[0]);
    if (keyword == "POINTS") return parse_points(words);
    if (keyword == "CELLS") return parse_cells(words);
    if (keyword == "CELL_TYPES") return parse_types(words);
    if (keyword == "POINT_DATA") return begin_data(Place::kPoints, words);
    if (keyword == "CELL_DATA") return begin_data(Place::kCells, words);
    if (keyword == "FIELD") return parse_field(words);
    if (keyword == "METADATA")
      return parse_metadata(place_ == Place::kField ? nullptr : last_array());
    if (place_ != Place::kField) {
      if (keyword == "SCALARS") return parse_scalars(words);
      if (keyword == "COLOR_SCALARS") return parse_colours(words);
      if (keyword == "LOOKUP_TABLE") return skip_table(words);
      for (const AttributeWord& attribute : kAttributes) {
        if (keyword == attribute.word) return parse_attribute(attribute, words);
      }
    }
    fail_at(begin,
            "expected a section, as POINTS, CELLS or POINT_DATA, found " + quoted(joined(words)) +
                (binary_ ? ": the section before it has another length than its counts say" : ""));
  }

  void once(const VtuArray& array, std::string_view keyword) const {
    if (array.present) {
      fail_at(place_of(keyword), "there are two sections " + in_capitals(keyword));
    }
  }

  void parse_points(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "POINTS COUNT TYPE");
    once(piece_.coordinates, words[0]);
    piece_.points = count_of(words[1]);
    piece_.coordinates = take_values("POINTS", words[2], piece_.points, 3);
  }

  void parse_cells(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "CELLS and two counts");
    once(piece_.connectivity, words[0]);
    const std::uint64_t first = count_of(words[1]);
    const std::uint64_t second = count_of(words[2]);
    if (major_ < 5) {
      piece_.cells = first;
      return take_counted_cells(second);
    }
    piece_.cells = first == 0 ? 0 : first - 1;
    piece_.offsets = take_cell_array("OFFSETS", first);
    piece_.connectivity = take_cell_array("CONNECTIVITY", second);
    if (first > 0) drop_first_offset();
  }

  VtuArray take_cell_array(std::string_view keyword, std::uint64_t values) {
    skip_to_keyword();
    const std::size_t begin = at_;
    const std::vector<std::string_view> words = take_words();
    if (words.size() < 2 || in_capitals(words[0]) != keyword) {
      fail_at(begin,
              "expected " + std::string(keyword) + " and a type, found " + quoted(joined(words)));
    }
    VtuArray array = take_values(std::string(keyword), words[1], values, 1);
    if (is_float(array.info.type)) {
      fail_at(begin, std::string(keyword) + ": expected integers, not " + quoted(words[1]));
    }
    return array;
  }

  // A .vtu has only where cells end.
  void drop_first_offset() {
    VtuArray& offsets = piece_.offsets;
    Payload& payload = offsets.payload;
    std::string_view first = text_.substr(payload.begin, payload.end - payload.begin);
    bool is_zero = false;
    if (binary_) {
      first = first.substr(0, size_of(offsets.info.type));
      is_zero = std::all_of(first.begin(), first.end(), [](char c) { return c == 0; });
    } else {
      first = TokenCursor(first, 0).next();
      is_zero = first == "0";
    }
    if (!is_zero) fail_at(place_of(first), "OFFSETS: expected the first one to be 0");
    payload.begin = place_of(first) + first.size();
    --offsets.info.tuples;
  }

  void take_counted_cells(std::uint64_t numbers) {
    if (piece_.cells > numbers) {
      fail_at(at_, "CELLS: " + std::to_string(piece_.cells) + " cells cannot be listed in " +
                       std::to_string(numbers) + " numbers");
    }
    const VtuArray list = take_values("CELLS", "int", numbers, 1);
    const CountedCells cells = count_cells(ArrayReader({&file_, "CELLS", list.payload, head_.layout,
                                                        list.info.type, list.info.values()}),
                                           piece_.cells);
    piece_.offsets = list;
    piece_.offsets.info = {"offsets", ValueType::kInt64, 1, {}, piece_.cells};
    piece_.offsets.computed = cells.offsets;
    piece_.connectivity = list;
    piece_.connectivity.info.tuples = numbers - piece_.cells;
    piece_.connectivity.computed = cells.connectivity;
  }

  void parse_types(const std::vector<std::string_view>& words) {
    expect_words(words, 2, "CELL_TYPES COUNT");
    once(piece_.types, words[0]);
    if (!piece_.connectivity.present) fail_at(place_of(words[0]), "CELLS must come before");
    const std::uint64_t types = count_of(words[1]);
    if (types != piece_.cells) {
      fail_at(place_of(words[1]), "there are " + std::to_string(types) + " CELL_TYPES, but " +
                                      std::to_string(piece_.cells) + " CELLS");
    }
    piece_.types = take_values("CELL_TYPES", "int", types, 1);
  }

  void begin_data(Place place, const std::vector<std::string_view>& words) {
    const bool points = place == Place::kPoints;
    expect_words(words, 2, points ? "POINT_DATA COUNT" : "CELL_DATA COUNT");
    if (!piece_.coordinates.present || !piece_.connectivity.present) {
      fail_at(place_of(words[0]), "POINTS and CELLS must come before data");
    }
    const std::uint64_t tuples = count_of(words[1]);
    const std::uint64_t expected = points ? piece_.points : piece_.cells;
    if (tuples != expected) {
      fail_at(place_of(words[1]), in_capitals(words[0]) + " is of " + std::to_string(tuples) +
                                      ", but there are " + std::to_string(expected) +
                                      (points ? " points" : " cells"));
    }
    place_ = place;
  }

  // ---- attributes ----

  std::uint64_t tuples() const { return place_ == Place::kPoints ? piece_.points : piece_.cells; }
  AttributeSet& set() { return place_ == Place::kPoints ? head_.point_data : head_.cell_data; }
  std::vector<VtuArray>& arrays() {
    return place_ == Place::kField    ? head_.field_data
           : place_ == Place::kPoints ? piece_.point_data
                                      : piece_.cell_data;
  }

  // The first of a kind is the one that is active.
  void parse_attribute(const AttributeWord& attribute, const std::vector<std::string_view>& words) {
    const bool counted = attribute.components == 0;
    expect_words(words, counted ? 4 : 3, counted ? "NAME COMPONENTS TYPE" : "NAME TYPE");
    const std::uint64_t components = counted ? count_of(words[2]) : attribute.components;
    const std::string name = decoded(words[1]);
    add_array(name, words[counted ? 3 : 2], tuples(), components);
    set().active.emplace(attribute.active, name);
  }

  void parse_scalars(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "SCALARS NAME TYPE");
    const std::string name = decoded(words[1]);
    const std::uint64_t components = words.size() > 3 ? count_of(words[3]) : 1;
    if (!binary_) skip_blanks();
    if (comes("LOOKUP_TABLE")) take_line();
    add_array(name, words[2], tuples(), components);
    set().active.emplace("Scalars", name);
  }

  void parse_colours(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "COLOR_SCALARS NAME COMPONENTS");
    const std::string name = decoded(words[1]);
    add_array(name, binary_ ? "unsigned_char" : "float", tuples(), count_of(words[2]));
    set().active.emplace("Scalars", name);
    if (binary_) return;
    VtuArray& array = arrays().back();
    array.computed =
        colours_of(ArrayReader({&file_, "COLOR_SCALARS " + name, array.payload, head_.layout,
                                ValueType::kFloat32, array.info.values()}));
    array.info.type = ValueType::kUInt8;
  }

  void skip_table(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "LOOKUP_TABLE NAME COUNT");
    take_values("LOOKUP_TABLE", binary_ ? "unsigned_char" : "float", count_of(words[2]), 4);
  }

  void parse_field(const std::vector<std::string_view>& words) {
    expect_words(words, 3, "FIELD NAME COUNT");
    const std::uint64_t count = count_of(words[2]);
    for (std::uint64_t i = 0; i < count; ++i) {
      skip_blanks();
      const std::vector<std::string_view> head = take_words();
      if (joined(head) == "NULL_ARRAY") continue;
      expect_words(head, 4, "NAME COMPONENTS TUPLES TYPE of an array");
      parse_field_array(head);
      skip_blanks();
      if (!comes("METADATA")) continue;
      take_line();
      parse_metadata(last_array());
    }
  }

  void parse_field_array(const std::vector<std::string_view>& head) {
    const std::string name = decoded(head[0]);
    const std::uint64_t components = count_of(head[1]);
    const std::uint64_t rows = count_of(head[2]);
    if (place_ != Place::kField && rows != tuples()) {
      fail_at(place_of(head[0]), "array \"" + name + "\" has " + std::to_string(rows) +
                                     " tuples, expected " + std::to_string(tuples()));
    }
    if (in_small_letters(head[3]) == "string") return take_strings(name, components, rows);
    add_array(name, head[3], rows, components);
  }

  void check_is_new(const std::string& name) {
    for (const VtuArray& known : arrays()) {
      if (known.info.name != name) continue;
      fail_at(at_, "there are two arrays called \"" + name + "\": rename one");
    }
  }
  // Adds an array to the place that we are in.
  void add_array(const std::string& name, std::string_view type, std::uint64_t rows,
                 std::uint64_t components) {
    check_is_new(name);
    arrays().push_back(take_values(name, type, rows, components));
  }
  VtuArray* last_array() { return arrays().empty() ? nullptr : &arrays().back(); }

  // ---- values ----

  const LegacyType& type_of(const std::string& name, std::string_view word) const {
    const std::string small = in_small_letters(word);
    for (const LegacyType& type : kTypes) {
      if (type.name == small) return type;
    }
    fail_at(at_, name + ": arrays of type " + quoted(word) +
                     " cannot be read, only those of VTK's integers, float and double");
  }

  // An array of rows * components values, which begin here.
  VtuArray take_values(const std::string& name, std::string_view type_word, std::uint64_t rows,
                       std::uint64_t components) {
    const LegacyType& type = type_of(name, type_word);
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
  std::size_t skip_numbers(const std::string& name, std::uint64_t count) {
    constexpr std::size_t kReleased = std::size_t{1} << 20;
    const std::size_t begin = at_;
    for (std::uint64_t i = 0; i < count; ++i) {
      while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
      if (at_ == text_.size() || !begins_number(at_)) {
        fail_at(at_, name + ": expected " + std::to_string(count) + " numbers, found " +
                         std::to_string(i));
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
  bool begins_number(std::size_t at) const {
    const char c = text_[at];
    if (c <= '9') return true;
    const char small = static_cast<char>(c | 0x20);
    if (small != 'n' && small != 'i') return false;
    const std::string word = in_small_letters(text_.substr(at, 3));
    return word == "nan" || word == "inf";
  }

  // ---- strings ----

  void take_strings(const std::string& name, std::uint64_t components, std::uint64_t rows) {
    std::uint64_t count = 0;
    if (__builtin_mul_overflow(rows, components, &count) || count > text_.size() - at_ + 1) {
      fail_at(at_, name + ": so many strings do not fit into the file");
    }
    Vector<std::byte> bytes;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::string text = binary_ ? take_binary_string(name) : decoded(take_line());
      if (place_ != Place::kField) continue;
      for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
      bytes.push_back(std::byte{0});
    }
    if (place_ != Place::kField) {
      left_out_.push_back(name);
      return;
    }
    check_is_new(name);
    VtuArray array;
    array.present = true;
    array.counted = false;
    array.info = {name, ValueType::kString, 1, {}, 0};
    array.computed = kept_bytes(std::move(bytes));
    arrays().push_back(std::move(array));
  }

  // Its length first: 6, 14, 30 or 62 bits of it, behind two that say which.
  std::string take_binary_string(const std::string& name) {
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

  // ---- what describes arrays ----

  // Up to an empty line.
  void parse_metadata(VtuArray* array) {
    while (at_ < text_.size()) {
      const std::string_view line = trimmed(take_line());
      if (line.empty()) return;
      if (in_capitals(line) == "COMPONENT_NAMES") parse_component_names(array);
    }
  }

  void parse_component_names(VtuArray* array) {
    if (array == nullptr) return;
    std::vector<std::string> names;
    for (std::uint32_t k = 0; k < array->info.components; ++k) {
      const std::size_t before = at_;
      const std::string_view line = trimmed(take_line());
      if (line.empty()) {
        at_ = before;
        return;
      }
      names.push_back(decoded(line));
    }
    array->info.component_names = std::move(names);
  }

  void describe_format() {
    head_.format = "VTK legacy unstructured grid, " + version_ + (binary_ ? ", binary" : ", ascii");
    for (std::size_t i = 0; i < left_out_.size(); ++i) {
      head_.format += (i == 0 ? "; left out: " : ", ") + left_out_[i] + " (strings)";
    }
  }

  const MappedFile& file_;
  std::string_view text_;
  std::size_t released_;  // pages before it are not held
  std::size_t at_;
  std::string version_;
  int major_ = 0;
  bool binary_ = false;
  Place place_ = Place::kField;
  VtuPiece piece_;
  VtuHead head_;
  std::vector<std::string> left_out_;
};

}  // namespace

bool is_legacy_grid(std::string_view text) {
  if (!text.starts_with(kMagic)) return false;
  constexpr std::size_t kEnough = 4096;
  text = text.substr(0, kEnough);
  for (int line = 0; line < 2; ++line) {
    const std::size_t end = text.find('\n');
    text = end == text.npos ? std::string_view() : text.substr(end + 1);
  }
  TokenCursor words(text, kComment);
  words.next();
  if (in_capitals(words.next()) != "DATASET") return true;
  // Or what is left of it, where the file is cut off.
  return std::string_view("UNSTRUCTURED_GRID").starts_with(in_capitals(words.next()));
}

VtuHead parse_legacy_head(const MappedFile& file) { return LegacyParser(file).run(); }

}  // namespace tetfusion
