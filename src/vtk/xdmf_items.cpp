#include "vtk/xdmf_items.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <type_traits>

#include "base/numbers.h"
#include "io/formats/byte_values.h"
#include "io/formats/text_tokens.h"
#include "io/vtk/listed_files.h"
#include "vtk/number_types.h"

namespace tetfusion {
namespace {

constexpr int kDeepest = 16;  // items in items

std::vector<std::uint64_t> counts_in(const std::string& text) {
  std::vector<std::uint64_t> counts;
  TokenCursor cursor(text, 0);
  for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
    const auto count = number_in<std::uint64_t>(token);
    if (!count) throw DataFault("has '" + std::string(token) + "' where a count is expected");
    counts.push_back(*count);
  }
  return counts;
}

Dimensions extent_said(pugi::xml_node item) {
  return counts_in(xdmf_attribute(item, {"Dimensions"}));
}

std::uint64_t count_of(const Dimensions& extent) {
  const auto count = value_count(extent);
  if (!count) throw DataFault("says " + extent_words(extent) + " values, more than can be");
  return *count;
}

void check_count(const Dimensions& said, std::uint64_t found) {
  if (said.empty() || value_count(said) == found) return;
  throw DataFault("says " + extent_words(said) + " values, and there are " + std::to_string(found));
}

// Of text without Precision: what is written loses nothing. Elsewhere it is 4.
int number_type(pugi::xml_node item, bool is_text) {
  const std::string kind = xdmf_attribute(item, {"NumberType", "DataType"}, "Float");
  const std::string bytes = xdmf_attribute(item, {"Precision"});
  const auto is = [&](std::string_view word) { return is_xdmf_word(kind, word); };
  const auto has = [&](std::string_view precision) { return bytes == precision; };
  if (is("Float")) {
    if (has("8") || (bytes.empty() && is_text)) return VTK_TYPE_FLOAT64;
    if (has("4") || bytes.empty()) return VTK_TYPE_FLOAT32;
  }
  if (is("Char") || (is("Int") && has("1"))) return VTK_TYPE_INT8;
  if (is("UChar") || (is("UInt") && has("1"))) return VTK_TYPE_UINT8;
  if (is("Short") || (is("Int") && has("2"))) return VTK_TYPE_INT16;
  if (is("UShort") || (is("UInt") && has("2"))) return VTK_TYPE_UINT16;
  if (is("Int") && (has("4") || bytes.empty())) return VTK_TYPE_INT32;
  if (is("UInt") && (has("4") || bytes.empty())) return VTK_TYPE_UINT32;
  if (is("Int") && has("8")) return VTK_TYPE_INT64;
  if (is("UInt") && has("8")) return VTK_TYPE_UINT64;
  throw DataUnread(
      "holds numbers of type " + kind + (bytes.empty() ? "" : ", Precision " + bytes) +
      ", which are not read: Float, Int, UInt, Char and UChar of 1, 2, 4 or 8 bytes are");
}

// Values of `from`, of which the part is made.
vtkSmartPointer<vtkDataArray> part_of(vtkDataArray* from, const Dimensions& extent,
                                      const Hyperslab& part) {
  auto out = new_numbers(from->GetDataType(), count_of(part.count));
  with_number_type(from->GetDataType(), [&](auto zero) {
    auto* to = numbers_of<decltype(zero)>(out);
    const auto* const values = numbers_of<decltype(zero)>(from);
    for_each_run(extent, part, [&](std::uint64_t first, std::uint64_t count) {
      to = std::copy_n(values + first, count, to);
    });
  });
  return out;
}

[[noreturn]] void fail_outside(const Hyperslab& part, const Dimensions& extent) {
  throw DataFault("takes " + extent_words(part.count) + " values from " + extent_words(part.start) +
                  " on, in steps of " + extent_words(part.stride) + ", which is not inside of " +
                  extent_words(extent));
}

bool is_swapped(pugi::xml_node item) {
  const std::string endian = xdmf_attribute(item, {"Endian"});
  if (is_xdmf_word(endian, "Big")) return std::endian::native == std::endian::little;
  if (is_xdmf_word(endian, "Little")) return std::endian::native == std::endian::big;
  return false;
}

void swap_bytes(vtkDataArray* array) {
  with_number_type(array->GetDataType(), [&](auto zero) {
    auto* const values = numbers_of<decltype(zero)>(array);
    for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
      values[i] =
          tetfusion::load<decltype(zero)>(reinterpret_cast<const std::byte*>(values + i), true);
    }
  });
}

bool is_hdf5_format(const std::string& format) {
  return is_xdmf_word(format, "HDF") || is_xdmf_word(format, "HDF5") || is_xdmf_word(format, "H5");
}

std::string item_type(pugi::xml_node item) {
  return xdmf_attribute(item, {"ItemType", "Type"}, "Uniform");
}

// The numbers behind the dollars of "JOIN($0, $1, $2)"; none: it is another function.
std::vector<std::uint64_t> joined_items(std::string_view function) {
  std::string words;
  for (const char c : function) {
    if (!is_blank(c)) words += c == ',' ? ' ' : c;
  }
  std::vector<std::uint64_t> numbers;
  if (words.size() < 6 || !is_xdmf_word(words.substr(0, 5), "JOIN(") || words.back() != ')') {
    return {};
  }
  const std::string arguments = words.substr(5, words.size() - 6);
  TokenCursor cursor(arguments, 0);
  for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
    const auto number = number_in<std::uint64_t>(token.substr(1));
    if (token.front() != '$' || !number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

vtkSmartPointer<vtkDataArray> XdmfItems::read(pugi::xml_node item) {
  try {
    return read_any(item, 0);
  } catch (const DataFault& fault) {
    document_.fail(item, fault.what());
  }
}

vtkSmartPointer<vtkDataArray> XdmfItems::read_if_known(pugi::xml_node item, std::string* why) {
  try {
    return read_any(item, 0);
  } catch (const DataUnread& unread) {
    *why = unread.what();
    return nullptr;
  } catch (const DataFault& fault) {
    document_.fail(item, fault.what());
  }
}

std::vector<double> XdmfItems::read_doubles(pugi::xml_node item) {
  const Array array = read(item);
  std::vector<double> values;
  with_number_type(array->GetDataType(), [&](auto zero) {
    const auto* const from = numbers_of<decltype(zero)>(array);
    values.assign(from, from + array->GetNumberOfTuples());
  });
  return values;
}

std::string XdmfItems::key(pugi::xml_node item) const {
  std::string key;
  if (is_xdmf_word(item_type(item), "Uniform") &&
      (is_hdf5_format(xdmf_attribute(item, {"Format"})) ||
       is_xdmf_word(xdmf_attribute(item, {"Format"}), "Binary"))) {
    for (const pugi::xml_attribute attribute : item.attributes()) {
      if (!is_xdmf_word(attribute.name(), "Name")) key += std::string(attribute.value()) + " ";
    }
    return key + document_.path_of(item) + " " + document_.text(item);
  }
  return "element " + std::to_string(item.hash_value());
}

XdmfItems::Array XdmfItems::read_any(pugi::xml_node item, int depth) {
  if (depth > kDeepest) throw DataFault("holds items in items without end");
  const std::string type = item_type(item);
  if (is_xdmf_word(type, "Uniform")) return read_uniform(item);
  if (is_xdmf_word(type, "HyperSlab")) return read_part(item, depth);
  if (is_xdmf_word(type, "Function")) return read_joined(item, depth);
  throw DataUnread("is of ItemType " + type +
                   ", which is not read: let ParaView save the file as .vtu");
}

XdmfItems::Array XdmfItems::read_uniform(pugi::xml_node item) {
  const std::string format = xdmf_attribute(item, {"Format"});
  if (is_hdf5_format(format)) return read_hdf5(item, nullptr);
  if (is_xdmf_word(format, "Binary")) return read_binary(item, extent_said(item), nullptr);
  if (format.empty() || is_xdmf_word(format, "XML")) return read_text(item);
  throw DataUnread("is of Format " + format + ", which is not read: XML, HDF and Binary are");
}

XdmfItems::Array XdmfItems::read_text(pugi::xml_node item) const {
  const std::vector<std::string_view> parts = XdmfDocument::text_parts(item);
  std::uint64_t found = 0;
  for (const std::string_view part : parts) {
    TokenCursor cursor(part, 0);
    while (!cursor.next().empty()) ++found;
  }
  check_count(extent_said(item), found);
  auto array = new_numbers(number_type(item, true), found);
  with_number_type(array->GetDataType(), [&](auto zero) {
    auto* to = numbers_of<decltype(zero)>(array);
    for (const std::string_view part : parts) {
      TokenCursor cursor(part, 0);
      for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
        const auto value = number_in<decltype(zero)>(token);
        if (!value) {
          throw DataFault("has '" + std::string(token.substr(0, 40)) + "' among its numbers, of " +
                          array->GetDataTypeAsString());
        }
        *to++ = *value;
      }
    }
  });
  return array;
}

// The file says how many rows there are, and not the XML: SeisSol counts those that there were when
// it wrote the step.
XdmfItems::Array XdmfItems::read_binary(pugi::xml_node item, const Dimensions& extent,
                                        const Hyperslab* part) {
  const std::string packing = xdmf_attribute(item, {"Compression"});
  if (!packing.empty() && !is_xdmf_word(packing, "Raw")) {
    throw DataUnread("is packed (" + packing + "), which is not read: write it raw");
  }
  if (extent.empty()) throw DataFault("says no Dimensions, which it must of a binary file");
  const MappedFile& file = binary(path_of(item, document_.text(item)));
  auto array = new_numbers(number_type(item, false), 0);
  const auto size = static_cast<std::uint64_t>(array->GetDataTypeSize());
  const std::vector<std::uint64_t> seek = counts_in(xdmf_attribute(item, {"Seek"}));
  const std::uint64_t begin = seek.empty() ? 0 : seek.front();
  const std::uint64_t held = begin > file.size() ? 0 : (file.size() - begin) / size;
  if (part == nullptr && count_of(extent) > held) {
    throw DataFault("says " + extent_words(extent) + " values of " + std::to_string(size) +
                    " bytes from byte " + std::to_string(begin) + " of " + file.path() +
                    " on, which ends at byte " + std::to_string(file.size()));
  }
  Dimensions there = extent;
  const std::uint64_t row = count_of({extent.begin() + 1, extent.end()});
  if (row > 0) there[0] = held / row;
  if (part != nullptr && !part->lies_in(there)) fail_outside(*part, there);
  const std::uint64_t count = count_of(part != nullptr ? part->count : extent);
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  if (count == 0) return array;
  const std::byte* const from = file.bytes().data() + begin;
  auto* to = static_cast<std::byte*>(array->GetVoidPointer(0));
  const auto copy = [&](std::uint64_t first, std::uint64_t values) {
    std::memcpy(to, from + first * size, values * size);
    to += values * size;
  };
  if (part != nullptr) {
    for_each_run(there, *part, copy);
  } else {
    copy(0, count);
  }
  file.dont_need(0, file.size());
  file.check();
  if (is_swapped(item)) swap_bytes(array);
  return array;
}

XdmfItems::Array XdmfItems::read_hdf5(pugi::xml_node item, const Hyperslab* part) {
  const Hdf5Place place = place_of(item);
  const Hdf5Data& file = hdf5(path_of(item, place.file));
  Hyperslab own;
  if (!place.part.empty() && place.part.size() < 3) {
    throw DataFault("names a part of a data set without its start, step and count");
  }
  if (!place.part.empty()) {
    own = {place.part[0], place.part[1], place.part[2]};
    if (own.count.empty() || own.start.size() != own.count.size() ||
        own.stride.size() != own.count.size()) {
      throw DataFault("names a part of a data set by " + std::to_string(own.start.size()) +
                      " starts, " + std::to_string(own.stride.size()) + " steps and " +
                      std::to_string(own.count.size()) +
                      " counts, where there must be one of each for every dimension");
    }
    if (part != nullptr) throw DataFault("takes a part of a part of a data set");
    part = &own;
  }
  if (part == nullptr) {
    check_count(extent_said(item), count_of(file.dimensions(place.name)));
    return file.read(place.name, nullptr);
  }
  const Dimensions extent = file.dimensions(place.name);
  if (part->start.size() == extent.size() && part->stride.size() == extent.size() &&
      part->count.size() == extent.size()) {
    if (!part->lies_in(extent)) fail_outside(*part, extent);
    return file.read(place.name, part);
  }
  // What is one row in the XML may have no rows in the file.
  const Dimensions said = extent_said(item);
  if (said.size() != part->count.size() || value_count(said) != count_of(extent)) {
    throw DataFault("takes a part along " + std::to_string(part->count.size()) +
                    " dimensions of the data set " + place.name + ", which has " +
                    extent_words(extent) + " values");
  }
  if (!part->lies_in(said)) fail_outside(*part, said);
  return part_of(file.read(place.name, nullptr), said, *part);
}

XdmfItems::Array XdmfItems::read_part(pugi::xml_node item, int depth) {
  const std::vector<pugi::xml_node> items = document_.children(item, "DataItem");
  if (items.size() != 2) {
    throw DataFault("is a HyperSlab of " + std::to_string(items.size()) +
                    " DataItems, where there must be two: which part, and of what");
  }
  const Hyperslab part = slab_of(items[0]);
  const pugi::xml_node source = items[1];
  check_count(extent_said(item), count_of(part.count));
  const bool is_uniform = is_xdmf_word(item_type(source), "Uniform");
  const std::string format = xdmf_attribute(source, {"Format"});
  if (is_uniform && is_hdf5_format(format)) return read_hdf5(source, &part);
  const Dimensions extent = extent_said(source);
  if (extent.size() != part.count.size()) {
    throw DataFault("takes a part along " + std::to_string(part.count.size()) + " dimensions of " +
                    extent_words(extent) + " values");
  }
  if (is_uniform && is_xdmf_word(format, "Binary")) return read_binary(source, extent, &part);
  const Array whole = read_any(source, depth + 1);
  check_count(extent, static_cast<std::uint64_t>(whole->GetNumberOfTuples()));
  if (!part.lies_in(extent)) fail_outside(part, extent);
  return part_of(whole, extent, part);
}

// Starts, steps and counts, a row of each.
Hyperslab XdmfItems::slab_of(pugi::xml_node list) {
  const std::vector<double> numbers = read_doubles(list);
  constexpr double kMost = 9007199254740992.0;  // whole numbers above it are not exact
  const bool are_counts = std::all_of(numbers.begin(), numbers.end(), [](double number) {
    return number >= 0 && number <= kMost &&
           number == static_cast<double>(static_cast<std::uint64_t>(number));
  });
  if (numbers.empty() || numbers.size() % 3 != 0 || !are_counts) {
    throw DataFault(
        "is a HyperSlab whose list is not a start, a step and a count for each dimension");
  }
  const std::size_t rank = numbers.size() / 3;
  Hyperslab part;
  for (std::size_t d = 0; d < rank; ++d) {
    part.start.push_back(static_cast<std::uint64_t>(numbers[d]));
    part.stride.push_back(static_cast<std::uint64_t>(numbers[rank + d]));
    part.count.push_back(static_cast<std::uint64_t>(numbers[2 * rank + d]));
  }
  return part;
}

// Columns side by side.
XdmfItems::Array XdmfItems::read_joined(pugi::xml_node item, int depth) {
  const std::string function = xdmf_attribute(item, {"Function"});
  if (depth > 0) throw DataUnread("is made of a Function, " + function + ", which is not read");
  const std::vector<std::uint64_t> columns = joined_items(function);
  const std::vector<pugi::xml_node> items = document_.children(item, "DataItem");
  const auto is_there = [&](std::uint64_t column) { return column < items.size(); };
  if (columns.empty() || !std::all_of(columns.begin(), columns.end(), is_there)) {
    throw DataUnread("is a Function, " + function +
                     ", which is not read: only JOIN of its items is");
  }
  Array out;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Array column = read_any(items[columns[k]], depth + 1);
    const auto rows = static_cast<std::uint64_t>(column->GetNumberOfTuples());
    if (k == 0) out = new_numbers(column->GetDataType(), rows * columns.size());
    if (column->GetDataType() != out->GetDataType() ||
        rows * columns.size() != static_cast<std::uint64_t>(out->GetNumberOfTuples())) {
      throw DataFault("joins items that are of different types or lengths");
    }
    with_number_type(out->GetDataType(), [&](auto zero) {
      const auto* const from = numbers_of<decltype(zero)>(column);
      auto* const to = numbers_of<decltype(zero)>(out);
      for (std::uint64_t row = 0; row < rows; ++row) to[row * columns.size() + k] = from[row];
    });
  }
  check_count(extent_said(item), static_cast<std::uint64_t>(out->GetNumberOfTuples()));
  return out;
}

XdmfItems::Hdf5Place XdmfItems::place_of(pugi::xml_node item) const {
  std::string text = document_.text(item);
  Hdf5Place place;
  if (const std::size_t bar = text.find('|'); bar != std::string::npos) {
    if (text.find('|', bar + 1) != std::string::npos) {
      throw DataUnread("is made of parts of several data sets, which is not read");
    }
    std::string lists = text.substr(bar);
    text.erase(bar);
    while (!lists.empty()) {
      lists.erase(0, 1);
      const std::size_t end = std::min(lists.find(':'), lists.size());
      place.part.push_back(counts_in(lists.substr(0, end)));
      lists.erase(0, end);
    }
  }
  const std::size_t root = text.find(":/");
  const std::size_t colon = root != std::string::npos ? root : text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) {
    throw DataFault("is in an HDF5 file, and '" + text.substr(0, 80) +
                    "' does not say FILE:/DATA_SET");
  }
  place.file = text.substr(0, text.find_last_not_of(' ', colon - 1) + 1);
  place.name = text.substr(colon + 1);
  return place;
}

std::string XdmfItems::path_of(pugi::xml_node item, const std::string& name) {
  std::string path = listed_path(document_.path_of(item), "the file that a DataItem names", name);
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) {
    throw DataFault("names the file " + path + ", which is not there");
  }
  if (!std::filesystem::is_regular_file(path, unknown) ||
      std::filesystem::file_size(path, unknown) == 0) {
    throw DataFault("names the file " + path + ", which is empty, or no file");
  }
  if (std::find(files_.begin(), files_.end(), path) == files_.end()) files_.push_back(path);
  return path;
}

const Hdf5Data& XdmfItems::hdf5(const std::string& path) {
  auto known = hdf5_.find(path);
  if (known == hdf5_.end()) known = hdf5_.emplace(path, Hdf5Data(path)).first;
  return known->second;
}

const MappedFile& XdmfItems::binary(const std::string& path) {
  auto known = binary_.find(path);
  if (known == binary_.end()) known = binary_.emplace(path, MappedFile::open(path)).first;
  return known->second;
}

}  // namespace tetfusion
