#include "io/vtk/legacy_head.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "io/formats/format_file.h"
#include "io/formats/text_tokens.h"
#include "io/formats/xml_text.h"
#include "io/vtk/counted_cells.h"
#include "io/vtk/legacy_arrays.h"
#include "io/vtk/legacy_text.h"

namespace tetfusion {

namespace {

constexpr std::string_view kFirstLine = "# vtk DataFile Version";

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

class LegacyParser {
 public:
  explicit LegacyParser(const MappedFile& file) : file_(file), in_(file) {}

  VtuHead run() {
    parse_first_lines();
    for (in_.skip_to_keyword(); !in_.at_end(); in_.skip_to_keyword()) parse_section();
    if (!piece_.coordinates.present) in_.fail("there are no POINTS");
    if (!piece_.connectivity.present) in_.fail("there are no CELLS");
    if (!piece_.types.present) in_.fail("there are no CELL_TYPES");
    in_.release();
    if (piece_.points == 0) piece_.point_data.clear();
    for (const VtuArray& a : piece_.point_data) head_.point_data.arrays.push_back(a.info);
    for (const VtuArray& a : piece_.cell_data) head_.cell_data.arrays.push_back(a.info);
    head_.pieces.push_back(std::move(piece_));
    describe_format();
    return std::move(head_);
  }

 private:
  enum class Place { kField, kPoints, kCells };

  // ---- the first lines ----

  void parse_first_lines() {
    if (in_.part(0, kFirstLine.size()) != kFirstLine) {
      in_.fail("expected a first line \"" + std::string(kFirstLine) +
               " 5.1\", as legacy .vtk files have");
    }
    const std::string_view line = in_.take_line();
    version_ = std::string(trimmed(line.substr(kFirstLine.size())));
    const auto [stop, error] =
        std::from_chars(version_.data(), version_.data() + version_.size(), major_);
    if (error != std::errc() || major_ < 1 || major_ > 5) {
      in_.fail("line 1: version " + quoted(version_) +
               " is not known, expected 1.0 to 5.1: VTK's writer makes one of 4.2 with "
               "SetFileVersion(42)");
    }
    in_.take_line();
    in_.skip_to_keyword();
    const std::string kind = in_capitals(trimmed(in_.take_line()));
    if (kind != "ASCII" && kind != "BINARY") {
      in_.fail("line 3: expected ASCII or BINARY, found " + quoted(kind));
    }
    in_.set_binary(kind == "BINARY");
    head_.layout = {Compressor::kNone, 0, std::endian::native == std::endian::little};
    in_.skip_to_keyword();
    const std::size_t begin = in_.at();
    const std::vector<std::string_view> words = in_.take_words();
    if (words.size() < 2 || in_capitals(words[0]) != "DATASET" ||
        in_capitals(words[1]) != "UNSTRUCTURED_GRID") {
      in_.fail_at(begin, "expected DATASET UNSTRUCTURED_GRID, found " + quoted(joined(words)));
    }
  }

  // ---- sections ----

  void parse_section() {
    const std::size_t begin = in_.at();
    const std::vector<std::string_view> words = in_.take_words();
    const std::string keyword = in_capitals(words[0]);
    if (keyword == "POINTS") return parse_points(words);
    if (keyword == "CELLS") return parse_cells(words);
    if (keyword == "CELL_TYPES") return parse_types(words);
    if (keyword == "POINT_DATA") return begin_data(Place::kPoints, words);
    if (keyword == "CELL_DATA") return begin_data(Place::kCells, words);
    if (keyword == "FIELD") return parse_field(words);
    if (keyword == "METADATA") return parse_metadata(described_array());
    if (place_ != Place::kField) {
      if (keyword == "SCALARS") return parse_scalars(words);
      if (keyword == "COLOR_SCALARS") return parse_colours(words);
      if (keyword == "LOOKUP_TABLE") return skip_table(words);
      for (const AttributeWord& attribute : kAttributes) {
        if (keyword == attribute.word) return parse_attribute(attribute, words);
      }
    }
    in_.fail_at(
        begin,
        "expected a section, as POINTS, CELLS or POINT_DATA, found " + quoted(joined(words)) +
            (in_.binary() ? ": the section before it has another length than its counts say" : ""));
  }

  void once(const VtuArray& array, std::string_view keyword) const {
    if (array.present) {
      in_.fail_at(in_.place_of(keyword), "there are two sections " + in_capitals(keyword));
    }
  }

  void parse_points(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "POINTS COUNT TYPE");
    once(piece_.coordinates, words[0]);
    piece_.points = in_.count_of(words[1]);
    described_.reset();
    piece_.coordinates = in_.take_values("POINTS", words[2], piece_.points, 3);
  }

  void parse_cells(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "CELLS and two counts");
    once(piece_.connectivity, words[0]);
    const std::uint64_t first = in_.count_of(words[1]);
    const std::uint64_t second = in_.count_of(words[2]);
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
    in_.skip_to_keyword();
    const std::size_t begin = in_.at();
    const std::vector<std::string_view> words = in_.take_words();
    if (words.size() < 2 || in_capitals(words[0]) != keyword) {
      in_.fail_at(begin, "expected " + std::string(keyword) + " and a type, found " +
                             quoted(joined(words)));
    }
    VtuArray array = in_.take_values(std::string(keyword), words[1], values, 1);
    if (is_float(array.info.type)) {
      in_.fail_at(begin, std::string(keyword) + ": expected integers, not " + quoted(words[1]));
    }
    return array;
  }

  // A .vtu has only where cells end.
  void drop_first_offset() {
    VtuArray& offsets = piece_.offsets;
    Payload& payload = offsets.payload;
    std::string_view first = in_.part(payload.begin, payload.end);
    bool is_zero = false;
    if (in_.binary()) {
      first = first.substr(0, size_of(offsets.info.type));
      is_zero = std::all_of(first.begin(), first.end(), [](char c) { return c == 0; });
    } else {
      first = TokenCursor(first, 0).next();
      is_zero = first == "0";
    }
    if (!is_zero) in_.fail_at(in_.place_of(first), "OFFSETS: expected the first one to be 0");
    payload.begin = in_.place_of(first) + first.size();
    --offsets.info.tuples;
  }

  void take_counted_cells(std::uint64_t numbers) {
    if (piece_.cells > numbers) {
      in_.fail_at(in_.at(), "CELLS: " + std::to_string(piece_.cells) +
                                " cells cannot be listed in " + std::to_string(numbers) +
                                " numbers");
    }
    const VtuArray list = in_.take_values("CELLS", "int", numbers, 1);
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
    in_.expect_words(words, 2, "CELL_TYPES COUNT");
    once(piece_.types, words[0]);
    if (!piece_.connectivity.present) in_.fail_at(in_.place_of(words[0]), "CELLS must come before");
    const std::uint64_t types = in_.count_of(words[1]);
    if (types != piece_.cells) {
      in_.fail_at(in_.place_of(words[1]), "there are " + std::to_string(types) +
                                              " CELL_TYPES, but " + std::to_string(piece_.cells) +
                                              " CELLS");
    }
    piece_.types = in_.take_values("CELL_TYPES", "int", types, 1);
  }

  void begin_data(Place place, const std::vector<std::string_view>& words) {
    const bool points = place == Place::kPoints;
    in_.expect_words(words, 2, points ? "POINT_DATA COUNT" : "CELL_DATA COUNT");
    if (!piece_.coordinates.present || !piece_.connectivity.present) {
      in_.fail_at(in_.place_of(words[0]), "POINTS and CELLS must come before data");
    }
    const std::uint64_t tuples = in_.count_of(words[1]);
    const std::uint64_t expected = points ? piece_.points : piece_.cells;
    if (tuples != expected) {
      in_.fail_at(in_.place_of(words[1]), in_capitals(words[0]) + " is of " +
                                              std::to_string(tuples) + ", but there are " +
                                              format_count(expected, points ? "point" : "cell"));
    }
    place_ = place;
    described_.reset();
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
    in_.expect_words(words, counted ? 4 : 3, counted ? "NAME COMPONENTS TYPE" : "NAME TYPE");
    const std::uint64_t components = counted ? in_.count_of(words[2]) : attribute.components;
    const std::string name = legible(decoded(words[1]));
    add_attribute(name, words[counted ? 3 : 2], components);
    set().active.emplace(attribute.active, name);
  }

  void parse_scalars(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "SCALARS NAME TYPE");
    const std::string name = legible(decoded(words[1]));
    const std::uint64_t components = words.size() > 3 ? in_.count_of(words[3]) : 1;
    if (!in_.binary()) in_.skip_blanks();
    if (in_.comes("LOOKUP_TABLE")) in_.take_line();
    std::string_view type = words[2];
    // FreeFem writes no blank before the number of components. No type ends so.
    if (words.size() == 3 && type.ends_with('1')) type.remove_suffix(1);
    add_attribute(name, type, components);
    set().active.emplace("Scalars", name);
  }

  void parse_colours(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "COLOR_SCALARS NAME COMPONENTS");
    const std::string name = legible(decoded(words[1]));
    add_array(name, in_.binary() ? "unsigned_char" : "float", tuples(), in_.count_of(words[2]));
    set().active.emplace("Scalars", name);
    if (in_.binary()) return;
    VtuArray& array = arrays().back();
    array.computed =
        colours_of(ArrayReader({&file_, "COLOR_SCALARS " + name, array.payload, head_.layout,
                                ValueType::kFloat32, array.info.values()}));
    array.info.type = ValueType::kUInt8;
  }

  void skip_table(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "LOOKUP_TABLE NAME COUNT");
    in_.take_values("LOOKUP_TABLE", in_.binary() ? "unsigned_char" : "float",
                    in_.count_of(words[2]), 4);
  }

  void parse_field(const std::vector<std::string_view>& words) {
    in_.expect_words(words, 3, "FIELD NAME COUNT");
    const std::uint64_t count = in_.count_of(words[2]);
    for (std::uint64_t i = 0; i < count; ++i) {
      in_.skip_blanks();
      const std::vector<std::string_view> head = in_.take_words();
      if (joined(head) == "NULL_ARRAY") continue;
      in_.expect_words(head, 4, "NAME COMPONENTS TUPLES TYPE of an array");
      parse_field_array(head);
      in_.skip_blanks();
      if (!in_.comes("METADATA")) continue;
      in_.take_line();
      parse_metadata(described_array());
    }
  }

  void parse_field_array(const std::vector<std::string_view>& head) {
    const std::string name = legible(decoded(head[0]));
    const std::uint64_t components = in_.count_of(head[1]);
    const std::uint64_t rows = in_.count_of(head[2]);
    if (place_ != Place::kField && rows != tuples()) {
      in_.fail_at(in_.place_of(head[0]), "array \"" + name + "\" has " + std::to_string(rows) +
                                             " tuples, expected " + std::to_string(tuples()));
    }
    if (in_small_letters(head[3]) == "string") return parse_strings(name, components, rows);
    add_array(name, head[3], rows, components);
  }

  void check_is_new(const std::string& name) {
    if (names_.emplace(place_, name).second) return;
    in_.fail_at(in_.at(), "there are two arrays called \"" + name + "\": rename one");
  }
  // Adds an array to the place that we are in.
  void add_array(const std::string& name, std::string_view type, std::uint64_t rows,
                 std::uint64_t components) {
    check_is_new(name);
    take_array(in_.take_values(name, type, rows, components));
  }
  void take_array(VtuArray array) {
    arrays().push_back(std::move(array));
    described_ = arrays().size() - 1;
  }
  // VTK writes an array that is active as several kinds once for each of them.
  void add_attribute(const std::string& name, std::string_view type, std::uint64_t components) {
    if (!names_.contains({place_, name})) return add_array(name, type, tuples(), components);
    const auto same = std::find_if(arrays().begin(), arrays().end(),
                                   [&](const VtuArray& a) { return a.info.name == name; });
    const std::size_t begin = in_.at();
    VtuArray again = in_.take_values(name, type, tuples(), components);
    if (again.info.type != same->info.type || again.info.components != same->info.components) {
      in_.fail_at(begin, "there are two arrays called \"" + name +
                             "\", of different types or numbers of components: rename one");
    }
    again.info.component_names = same->info.component_names;
    again.info.units = same->info.units;
    *same = std::move(again);
    described_ = static_cast<std::size_t>(same - arrays().begin());
  }
  // The one that METADATA which come next are of; nullptr: one that is left out.
  VtuArray* described_array() { return described_ ? &arrays()[*described_] : nullptr; }

  // Of field data; elsewhere they are left out.
  void parse_strings(const std::string& name, std::uint64_t components, std::uint64_t rows) {
    Vector<std::byte> bytes;
    const bool wanted = place_ == Place::kField;
    in_.take_strings(name, rows, components, wanted ? &bytes : nullptr);
    if (!wanted) {
      head_.unread.push_back(name);
      described_.reset();
      return;
    }
    check_is_new(name);
    VtuArray array;
    array.present = true;
    array.counted = false;
    array.info = {name, ValueType::kString, 1, {}, 0};
    array.computed = kept_bytes(std::move(bytes));
    take_array(std::move(array));
  }

  // ---- what describes arrays ----

  // Up to an empty line.
  void parse_metadata(VtuArray* array) {
    while (!in_.at_end()) {
      const std::string_view line = trimmed(in_.take_line());
      if (line.empty()) return;
      if (in_capitals(line) == "COMPONENT_NAMES") parse_component_names(array);
      if (says_units(line)) parse_units(array);
    }
  }

  // "NAME UNITS_LABEL LOCATION vtkDataArray", and in the next line "DATA m/s".
  static bool says_units(std::string_view line) {
    TokenCursor words(line, 0);
    return in_capitals(words.next()) == "NAME" && words.next() == kUnitsKey &&
           in_capitals(words.next()) == "LOCATION" && words.next() == kUnitsKeyClass;
  }

  void parse_units(VtuArray* array) {
    constexpr std::string_view kWord = "DATA";
    if (!in_.comes(kWord)) return;
    const std::string_view line = in_.take_line();
    if (array != nullptr) array->info.units = legible(decoded(trimmed(line.substr(kWord.size()))));
  }

  // A line a component, which is empty where the component has no name.
  void parse_component_names(VtuArray* array) {
    if (array == nullptr) return;
    std::vector<std::string> names;
    bool any = false;
    while (names.size() < array->info.components && !in_.at_end()) {
      names.push_back(legible(decoded(trimmed(in_.take_line()))));
      any = any || !names.back().empty();
    }
    if (any && names.size() == array->info.components) {
      array->info.component_names = std::move(names);
    }
  }

  void describe_format() {
    head_.format =
        "VTK legacy unstructured grid, " + version_ + (in_.binary() ? ", binary" : ", ascii");
  }

  const MappedFile& file_;
  LegacyText in_;
  std::string version_;
  int major_ = 0;
  Place place_ = Place::kField;
  std::set<std::pair<Place, std::string>> names_;  // of arrays
  std::optional<std::size_t> described_;           // of arrays(): the last one that was met
  VtuPiece piece_;
  VtuHead head_;
};

}  // namespace

bool is_legacy_grid(std::string_view text) {
  if (!text.starts_with(kFirstLine)) return false;
  constexpr std::size_t kEnough = 4096;
  text = text.substr(0, kEnough);
  for (int line = 0; line < 2; ++line) {
    const std::size_t end = text.find('\n');
    text = end == text.npos ? std::string_view() : text.substr(end + 1);
  }
  TokenCursor words(text, kLegacyComment);
  words.next();
  if (in_capitals(words.next()) != "DATASET") return true;
  // Or what is left of it, where the file is cut off.
  return std::string_view("UNSTRUCTURED_GRID").starts_with(in_capitals(words.next()));
}

VtuHead parse_legacy_head(const MappedFile& file) { return LegacyParser(file).run(); }

}  // namespace tetfusion
