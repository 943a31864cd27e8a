#include "io/vtk/vtu_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "io/formats/format_file.h"
#include "io/formats/xml_text.h"
#include "io/vtk/xml_scan.h"

namespace tetfusion {

namespace {

bool parse_unsigned(std::string_view text, std::uint64_t* value) {
  const auto number = number_in<std::uint64_t>(trimmed(text));
  if (number) *value = *number;
  return number.has_value();
}

class VtuHeadParser {
 public:
  explicit VtuHeadParser(const MappedFile& file) : file_(file), path_(file.path()) {}

  VtuHead run() {
    xml_ = scan_xml_head(file_);
    const pugi::xml_parse_result result = document_.load_buffer_inplace(
        xml_.text.data(), xml_.text.size(), pugi::parse_default, pugi::encoding_utf8);
    if (result.status == pugi::status_no_document_element) {
      fail("no <VTKFile> element: this is not a VTK XML file");
    }
    if (!result) {
      // The parser has changed the text.
      const std::string text = scan_xml_head(file_).text;
      const auto at = std::min(static_cast<std::size_t>(result.offset), text.size());
      const std::string_view rest = std::string_view(text).substr(at);
      fail(fmt::format("the XML head is damaged or cut off: {}, {}", result.description(),
                       rest.empty() ? "at its end" : "where it says " + quoted(rest)));
    }
    const pugi::xml_node root = document_.child("VTKFile");
    if (!root) fail("no <VTKFile> element: this is not a VTK XML file");
    parse_root(root);
    const pugi::xml_node grid = root.child("UnstructuredGrid");
    if (!grid) fail("no <UnstructuredGrid> element");
    refuse_time_steps(grid.attribute("TimeValues").value());
    parse_field_data(grid.child("FieldData"));
    const auto pieces = grid.children("Piece");
    piece_count_ = static_cast<std::size_t>(std::distance(pieces.begin(), pieces.end()));
    if (piece_count_ == 0) fail("no <Piece> element: the mesh is empty");
    for (const pugi::xml_node node : pieces) parse_piece(node);
    describe_format();
    return std::move(head_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, path_ + ": " + what);
  }

  static bool is_array(pugi::xml_node node) {
    return std::string_view(node.name()) == "DataArray" || std::string_view(node.name()) == "Array";
  }

  // " of piece 2" where there are several.
  std::string of_piece() const {
    return piece_count_ > 1 ? " of piece " + std::to_string(head_.pieces.size()) : "";
  }

  void parse_root(pugi::xml_node root) {
    const std::string_view type = root.attribute("type").value();
    if (type != "UnstructuredGrid") {
      fail("its type is \"" + std::string(type) + "\", expected \"UnstructuredGrid\"");
    }
    parse_version(root.attribute("version").value());
    const std::string_view order = root.attribute("byte_order").as_string("LittleEndian");
    if (order != "LittleEndian" && order != "BigEndian") {
      fail("unknown byte_order \"" + std::string(order) + "\"");
    }
    head_.layout.swap = order == "BigEndian";
    const std::string_view header = root.attribute("header_type").as_string("UInt32");
    if (header != "UInt32" && header != "UInt64") {
      fail("unknown header_type \"" + std::string(header) + "\", expected UInt32 or UInt64");
    }
    head_.layout.header_bytes = header == "UInt64" ? 8 : 4;
    head_.layout.compressor = parse_compressor(root.attribute("compressor").value());
    const pugi::xml_node appended = root.child("AppendedData");
    const std::string_view encoding = appended.attribute("encoding").as_string("base64");
    if (appended && encoding != "raw" && encoding != "base64") {
      fail("unknown encoding \"" + std::string(encoding) + "\" of the appended data");
    }
    appended_coding_ = encoding == "raw" ? Coding::kRaw : Coding::kBase64;
  }

  // VTK writes several steps to one file as arrays of one name, or as one piece after the other:
  // each of these says that it is step 0, and none tells that it is no part of the first.
  void refuse_time_steps(const std::string& times) const {
    std::istringstream words(times);
    const auto steps = std::distance(std::istream_iterator<std::string>(words), {});
    if (steps < 2) return;
    fail(
        fmt::format("it has {} time steps (TimeValues), which are not read from one .vtu: write "
                    "each to a file of its own, as ParaView's Save Data does with Write Time Steps",
                    steps));
  }

  void parse_version(std::string_view version) const {
    std::uint64_t major = 0;
    if (!version.empty() && !parse_unsigned(version.substr(0, version.find('.')), &major)) {
      fail("cannot read the version \"" + std::string(version) + "\"");
    }
    if (major > 2) {
      fail("version \"" + std::string(version) + "\" is not known, expected 0.1 to 2.x");
    }
  }

  Compressor parse_compressor(std::string_view name) const {
    if (name.empty()) return Compressor::kNone;
    if (name == "vtkZLibDataCompressor") return Compressor::kZlib;
    if (name == "vtkLZ4DataCompressor") return Compressor::kLz4;
    if (name == "vtkLZMADataCompressor") return Compressor::kLzma;
    fail("unknown compressor \"" + std::string(name) +
         "\", expected vtkZLibDataCompressor, vtkLZ4DataCompressor or vtkLZMADataCompressor");
  }

  // ---- arrays ----

  // `tuples` is what the piece says, or nothing where the array itself must say it.
  VtuArray parse_array(pugi::xml_node node, const std::string& kind, std::string_view fallback_name,
                       std::optional<std::uint64_t> tuples) {
    VtuArray array;
    array.present = true;
    const std::string_view name = node.attribute("Name").value();
    array.info.name = legible(name.empty() ? fallback_name : name);
    const std::string label = kind + " \"" + array.info.name + "\"" + of_piece();
    const std::string_view type = node.attribute("type").value();
    if (!parse_vtk_type(type, &array.info.type)) {
      fail(label + ": unknown type \"" + std::string(type) + "\"");
    }
    if (array.info.type == ValueType::kString && tuples) fail(label + ": strings are no numbers");
    parse_components(node, label, &array.info);
    array.info.units = units_of(node);
    if (!tuples) {
      const pugi::xml_attribute own = node.attribute("NumberOfTuples");
      // The number of strings does not tell the number of bytes.
      array.counted = own && array.info.type != ValueType::kString;
      if (own && !parse_unsigned(own.value(), &array.info.tuples)) {
        fail(label + ": NumberOfTuples is not a number");
      }
    } else {
      array.info.tuples = *tuples;
    }
    parse_payload(node, label, &array.payload);
    if (array.counted) check_room(array, label);
    return array;
  }

  void parse_components(pugi::xml_node node, const std::string& label, ArrayInfo* info) const {
    const pugi::xml_attribute components = node.attribute("NumberOfComponents");
    std::uint64_t count = 1;
    if (components && (!parse_unsigned(components.value(), &count) || count == 0 ||
                       count > std::numeric_limits<std::uint32_t>::max())) {
      fail(label + ": NumberOfComponents is \"" + components.value() + "\"");
    }
    info->components = static_cast<std::uint32_t>(count);
    constexpr std::string_view kPrefix = "ComponentName";
    for (const pugi::xml_attribute a : node.attributes()) {
      const std::string_view name = a.name();
      std::uint64_t index = 0;
      if (!name.starts_with(kPrefix) || !parse_unsigned(name.substr(kPrefix.size()), &index) ||
          index >= count) {
        continue;
      }
      // A short file could ask for many: nobody names so many.
      constexpr std::uint64_t kMaxNamed = 256;
      if (count > kMaxNamed) return;
      info->component_names.resize(count);
      info->component_names[index] = legible(a.value());
    }
  }

  void parse_payload(pugi::xml_node node, const std::string& label, Payload* payload) const {
    const pugi::xml_attribute offset = node.attribute("offset");
    const std::string_view format =
        node.attribute("format").as_string(offset ? "appended" : "ascii");
    if (format == "appended") {
      if (!xml_.has_appended) fail(label + ": is appended, but the file has no <AppendedData>");
      std::uint64_t begin = 0;
      if (!parse_unsigned(offset.value(), &begin)) {
        fail(label + ": offset is \"" + offset.value() + "\", expected a number");
      }
      if (begin > xml_.appended_end - xml_.appended_begin) {
        fail(label + ": offset " + std::to_string(begin) +
             " lies behind the end of the data: the file is " + "cut off or damaged");
      }
      *payload = {appended_coding_, true, xml_.appended_begin + begin, xml_.appended_end};
      return;
    }
    if (format != "binary" && format != "ascii") {
      fail(label + ": unknown format \"" + std::string(format) + "\"");
    }
    payload->coding = format == "binary" ? Coding::kBase64 : Coding::kAscii;
    // scan_xml_head has put the place of the text here.
    const std::string_view place = trimmed(node.text().get());
    const std::size_t blank = place.find(' ');
    if (place.empty()) return;
    if (blank == std::string_view::npos ||
        !parse_unsigned(place.substr(0, blank), &payload->begin) ||
        !parse_unsigned(place.substr(blank), &payload->end)) {
      fail(label + ": its data cannot be found");
    }
  }

  void check_room(const VtuArray& array, const std::string& label) const {
    const std::uint64_t room = max_values(array.payload, head_.layout, array.info.type);
    if (array.info.tuples > room / array.info.components) {
      fail(label + ": the file says " + std::to_string(array.info.tuples) + " tuples of " +
           std::to_string(array.info.components) +
           ", more than there is room for: it is cut off or damaged");
    }
  }

  void check_names(const std::vector<VtuArray>& arrays, const std::string& where) const {
    std::vector<std::string_view> names;
    for (const VtuArray& a : arrays) names.push_back(a.info.name);
    std::sort(names.begin(), names.end());
    const auto twice = std::adjacent_find(names.begin(), names.end());
    if (twice != names.end()) {
      fail(where + of_piece() + " has two arrays called \"" + std::string(*twice) +
           "\": rename one");
    }
  }

  // ---- pieces ----

  void parse_piece(pugi::xml_node node) {
    VtuPiece piece;
    if (!parse_unsigned(node.attribute("NumberOfPoints").value(), &piece.points) ||
        !parse_unsigned(node.attribute("NumberOfCells").value(), &piece.cells)) {
      fail("NumberOfPoints and NumberOfCells" + of_piece() + " must be numbers");
    }
    if (piece.points > 0) {
      parse_coordinates(node.child("Points"), &piece);
      parse_attributes(node.child("PointData"), "point array", piece.points, &piece.point_data);
      merge_attributes(node.child("PointData"), "point array", piece.points, &piece.point_data,
                       &head_.point_data, &points_seen_);
    }
    if (piece.cells > 0) {
      parse_cells(node.child("Cells"), &piece);
      parse_attributes(node.child("CellData"), "cell array", piece.cells, &piece.cell_data);
      merge_attributes(node.child("CellData"), "cell array", piece.cells, &piece.cell_data,
                       &head_.cell_data, &cells_seen_);
    }
    head_.pieces.push_back(std::move(piece));
  }

  void parse_coordinates(pugi::xml_node node, VtuPiece* piece) {
    for (const pugi::xml_node child : node.children()) {
      if (!is_array(child)) continue;
      if (piece->coordinates.present) fail("Points" + of_piece() + " has more than one array");
      piece->coordinates = parse_array(child, "coordinates", "Points", piece->points);
    }
    if (!piece->coordinates.present) fail("the coordinates" + of_piece() + " are missing");
    if (piece->coordinates.info.components != 3) {
      fail("the coordinates" + of_piece() + " have " +
           std::to_string(piece->coordinates.info.components) + " components, expected 3");
    }
    const ValueType type = piece->coordinates.info.type;
    if (!points_seen_) point_type_ = type;
    if (type != point_type_) {
      fail("the coordinates" + of_piece() + " are " + std::string(vtk_name(type)) +
           ", in the pieces before it " + std::string(vtk_name(point_type_)));
    }
  }

  void parse_cells(pugi::xml_node node, VtuPiece* piece) {
    for (const pugi::xml_node child : node.children()) {
      if (!is_array(child)) continue;
      const std::string_view name = child.attribute("Name").value();
      VtuArray* array = nullptr;
      if (name == "connectivity") array = &piece->connectivity;
      if (name == "offsets") array = &piece->offsets;
      if (name == "types") array = &piece->types;
      piece->has_faces = piece->has_faces || name == "faces" || name == "face_connectivity";
      if (array == nullptr) continue;
      if (array->present)
        fail("Cells" + of_piece() + " has two arrays called " + std::string(name));
      // Only the last offset tells the length of the connectivity.
      const bool counted = array != &piece->connectivity;
      *array = parse_array(child, "cell array", name, counted ? piece->cells : 0);
      array->counted = counted;
      if (is_float(array->info.type) || array->info.components != 1) {
        fail("cell array \"" + std::string(name) + "\"" + of_piece() + ": expected integers, not " +
             std::string(vtk_name(array->info.type)) + " in " +
             std::to_string(array->info.components) + " components");
      }
    }
    for (const auto& [array, name] : {std::pair{&piece->connectivity, "connectivity"},
                                      {&piece->offsets, "offsets"},
                                      {&piece->types, "types"}}) {
      if (!array->present)
        fail(std::string("the array \"") + name + "\"" + of_piece() + " is missing");
    }
  }

  void parse_attributes(pugi::xml_node node, const std::string& kind, std::uint64_t tuples,
                        std::vector<VtuArray>* arrays) {
    for (const pugi::xml_node child : node.children()) {
      if (!is_array(child)) continue;
      const std::string_view type = child.attribute("type").value();
      if (type == "String" || type == "Bit") {
        leave_unread(child);
      } else {
        arrays->push_back(parse_array(child, kind, unnamed(*arrays), tuples));
      }
    }
    check_names(*arrays, node.name());
  }

  void parse_field_data(pugi::xml_node node) {
    for (const pugi::xml_node child : node.children()) {
      if (!is_array(child)) continue;
      if (std::string_view(child.attribute("type").value()) == "Bit") {
        leave_unread(child);
      } else {
        head_.field_data.push_back(
            parse_array(child, "field array", unnamed(head_.field_data), {}));
      }
    }
    check_names(head_.field_data, "FieldData");
  }

  void leave_unread(pugi::xml_node array) {
    const std::string name = array.attribute("Name").value();
    auto& unread = head_.unread;
    if (std::find(unread.begin(), unread.end(), name) == unread.end()) unread.push_back(name);
  }

  // For the next of the arrays, if it has none.
  static std::string unnamed(const std::vector<VtuArray>& arrays) {
    return "unnamed_" + std::to_string(arrays.size());
  }

  // Compares a piece's arrays with those of the first piece that has any points (cells), and puts
  // them in that order.
  void merge_attributes(pugi::xml_node node, const std::string& kind, std::uint64_t tuples,
                        std::vector<VtuArray>* arrays, AttributeSet* all, bool* seen) {
    if (!*seen) {
      *seen = true;
      for (const VtuArray& a : *arrays) all->arrays.push_back(a.info);
      for (const pugi::xml_attribute a : node.attributes()) {
        const std::string name = legible(a.value());
        if (all->find(name) != AttributeSet::npos) all->active[a.name()] = name;
      }
      return;
    }
    std::vector<VtuArray> ordered(all->arrays.size());
    for (VtuArray& array : *arrays) {
      const std::size_t index = all->find(array.info.name);
      const std::string label = kind + " \"" + array.info.name + "\"";
      if (index == AttributeSet::npos) {
        fail(label + " is in piece " + std::to_string(head_.pieces.size()) +
             ", but not in the pieces before it");
      }
      const ArrayInfo& first = all->arrays[index];
      if (first.type != array.info.type || first.components != array.info.components) {
        fail(label + of_piece() + " has " + std::to_string(array.info.components) +
             " components of " + std::string(vtk_name(array.info.type)) +
             ", in the pieces before it " + std::to_string(first.components) + " of " +
             std::string(vtk_name(first.type)));
      }
      ordered[index] = std::move(array);
    }
    for (std::size_t i = 0; i < ordered.size(); ++i) {
      if (!ordered[i].present) {
        fail(kind + " \"" + all->arrays[i].name + "\" is missing in piece " +
             std::to_string(head_.pieces.size()));
      }
      all->arrays[i].tuples += tuples;
    }
    *arrays = std::move(ordered);
  }

  void describe_format() {
    const VtuArray* sample = nullptr;
    for (const VtuPiece& piece : head_.pieces) {
      if (sample == nullptr && piece.coordinates.present) sample = &piece.coordinates;
    }
    head_.format = "VTK XML unstructured grid";
    if (sample == nullptr) return;
    const Payload& payload = sample->payload;
    if (payload.coding == Coding::kAscii) {
      head_.format += ", ascii";
      return;
    }
    head_.format += !payload.appended                ? ", inline base64"
                    : payload.coding == Coding::kRaw ? ", appended raw"
                                                     : ", appended base64";
    if (head_.layout.compressor == Compressor::kZlib) head_.format += ", zlib";
    if (head_.layout.compressor == Compressor::kLz4) head_.format += ", lz4";
    if (head_.layout.compressor == Compressor::kLzma) head_.format += ", lzma";
    head_.format += head_.layout.header_bytes == 8 ? ", UInt64 headers" : ", UInt32 headers";
    if (head_.layout.swap) head_.format += ", big-endian";
  }

  const MappedFile& file_;
  const std::string& path_;
  XmlHead xml_;
  pugi::xml_document document_;
  Coding appended_coding_ = Coding::kBase64;
  std::size_t piece_count_ = 0;
  bool points_seen_ = false;  // a piece with points came before
  ValueType point_type_ = ValueType::kFloat32;
  bool cells_seen_ = false;
  VtuHead head_;
};

}  // namespace

VtuHead parse_vtu_head(const MappedFile& file) { return VtuHeadParser(file).run(); }

std::string units_of(const pugi::xml_node& array) {
  for (const pugi::xml_node key : array.children("InformationKey")) {
    if (key.attribute("name").value() == kUnitsKey &&
        key.attribute("location").value() == kUnitsKeyClass) {
      return legible(trimmed(key.text().get()));
    }
  }
  return {};
}

}  // namespace tetfusion
