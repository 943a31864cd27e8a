#include "io/vtk/legacy_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "io/formats/text_rows.h"
#include "io/vtk/decode.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// What an active array of so many components (0: of 1 to 3) is written as.
struct WrittenAttribute {
  const char* active;  // VTK's name of it
  std::uint32_t components;
  const char* word;
};
constexpr std::array<WrittenAttribute, 8> kWrittenAttributes = {
    {{"Vectors", 3, "VECTORS"},
     {"Normals", 3, "NORMALS"},
     {"Tensors", 9, "TENSORS"},
     {"Tensors", 6, "TENSORS6"},
     {"TCoords", 0, "TEXTURE_COORDINATES"},
     {"GlobalIds", 1, "GLOBAL_IDS"},
     {"PedigreeIds", 1, "PEDIGREE_IDS"},
     {"EdgeFlag", 1, "EDGE_FLAGS"}}};

const char* type_name(ValueType type) {
  switch (type) {
    case ValueType::kInt8:
      return "signed_char";
    case ValueType::kUInt8:
      return "unsigned_char";
    case ValueType::kInt16:
      return "short";
    case ValueType::kUInt16:
      return "unsigned_short";
    case ValueType::kInt32:
      return "int";
    case ValueType::kUInt32:
      return "unsigned_int";
    case ValueType::kInt64:
      return "vtktypeint64";
    case ValueType::kUInt64:
      return "vtktypeuint64";
    case ValueType::kFloat32:
      return "float";
    case ValueType::kFloat64:
      return "double";
    case ValueType::kString:
      return "string";
  }
  return "";
}

// As VTK does: a name is one word.
std::string encoded(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c > ' ' && c < '\x7f' && c != '"' && c != '%') {
      out += c;
    } else {
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return out;
}

// Of an array. Where one begins VTK takes these for keywords.
std::string encoded_name(std::string_view name) {
  const auto begins_with = [&](std::string_view keyword) {
    return std::ranges::equal(name.substr(0, keyword.size()), keyword, [](char a, char b) {
      return std::toupper(static_cast<unsigned char>(a)) == b;
    });
  };
  if (!begins_with("METADATA") && !begins_with("NULL_ARRAY")) return encoded(name);
  return fmt::format("%{:02X}{}", static_cast<unsigned char>(name[0]), encoded(name.substr(1)));
}

class LegacyWriter {
 public:
  LegacyWriter(MeshPasses* mesh, OutputFile* file, bool binary)
      : mesh_(*mesh), file_(file), binary_(binary) {}

  void run(const std::function<void(double)>& progress) {
    const MeshDescription& d = mesh_.description();
    mesh_.expect((1 + d.point_data.arrays.size()) * mesh_.points() +
                     (1 + d.cell_data.arrays.size()) * mesh_.tets(),
                 progress);
    put_text(fmt::format("# vtk DataFile Version 5.1\nTetFusion\n{}\nDATASET UNSTRUCTURED_GRID\n",
                         binary_ ? "BINARY" : "ASCII"),
             file_);
    put_field_data();
    put_points();
    put_cells();
    put_attributes("CELL_DATA", d.cell_data, cells(), [&](std::size_t i) { put_cell_rows(i); });
    put_attributes("POINT_DATA", d.point_data, mesh_.points(),
                   [&](std::size_t i) { put_point_rows(i); });
  }

 private:
  std::uint64_t cells() const { return mesh_.tets() + mesh_.lower().size(); }

  // ---- values ----

  void put_values(ValueType type, std::size_t columns, std::span<const std::byte> values) {
    if (binary_) {
      buffer_.assign(values.begin(), values.end());
      if (std::endian::native == std::endian::little) swap_bytes(buffer_, size_of(type));
      return file_->append(buffer_.data(), buffer_.size());
    }
    visit_type(type, [&](auto zero) {
      using T = decltype(zero);
      put_text_rows(values.size() / (columns * sizeof(T)), file_, [&](std::size_t i, TextRow* row) {
        for (std::size_t k = 0; k < columns; ++k) {
          T value;
          std::memcpy(&value, values.data() + (i * columns + k) * sizeof(T), sizeof(T));
          if constexpr (sizeof(T) == 1) {
            row->add(static_cast<int>(value));
          } else {
            row->add(value);
          }
        }
      });
    });
  }

  template <class T>
  void put_values(std::size_t columns, const Vector<T>& values) {
    put_values(value_type_of<T>(), columns, std::as_bytes(std::span(values)));
  }

  // Calls fill(first, &values) for runs of `count` values, which it makes.
  template <class T, class F>
  void put_computed(std::uint64_t count, F fill) {
    constexpr std::uint64_t kRun = std::uint64_t{1} << 20;
    for (std::uint64_t first = 0; first < count; first += kRun) {
      Vector<T> values(std::min(kRun, count - first));
      fill(first, &values);
      put_values(1, values);
    }
  }

  void end_values() {
    if (binary_) put_text("\n", file_);
  }

  // ---- geometry ----

  void put_points() {
    const ValueType type = mesh_.description().point_type;
    put_text(fmt::format("POINTS {} {}\n", mesh_.points(), type_name(type)), file_);
    mesh_.for_each_points(
        {}, [&](std::uint64_t, const Points& points, const std::vector<Vector<std::byte>>&) {
          std::visit([&](const auto& xyz) { put_values(type, 3, std::as_bytes(std::span(xyz))); },
                     points);
        });
    end_values();
  }

  void put_cells() {
    const LowerCells& lower = mesh_.lower();
    const std::uint64_t tets = mesh_.tets();
    const auto corners = static_cast<std::int64_t>(4 * tets);
    put_text(fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", cells() + 1,
                         4 * tets + lower.connectivity.size()),
             file_);
    put_computed<std::int64_t>(cells() + 1, [&](std::uint64_t first, auto* values) {
      for (std::uint64_t i = 0; i < values->size(); ++i) {
        const std::uint64_t cell = first + i;
        (*values)[i] = cell <= tets
                           ? static_cast<std::int64_t>(4 * cell)
                           : corners + static_cast<std::int64_t>(lower.offsets[cell - tets]);
      }
    });
    end_values();
    put_text("CONNECTIVITY vtktypeint64\n", file_);
    mesh_.for_each_tets(
        {}, [&](std::uint64_t, const Vector<Tet>& window, const std::vector<Vector<std::byte>>&) {
          Vector<std::int64_t> ids;
          ids.reserve(4 * window.size());
          for (const Tet& tet : window) ids.insert(ids.end(), tet.begin(), tet.end());
          put_values(4, ids);
        });
    put_values(1, Vector<std::int64_t>(lower.connectivity.begin(), lower.connectivity.end()));
    end_values();
    put_text(fmt::format("CELL_TYPES {}\n", cells()), file_);
    put_computed<std::int32_t>(cells(), [&](std::uint64_t first, auto* values) {
      for (std::uint64_t i = 0; i < values->size(); ++i) {
        const std::uint64_t cell = first + i;
        (*values)[i] = cell < tets ? std::uint8_t{kVtkTetra} : lower.types[cell - tets];
      }
    });
    end_values();
  }

  // ---- arrays ----

  // What the array's sections begin with, one for each kind that it is active as; nothing where it
  // is one among others in a FIELD.
  static std::vector<std::string> attribute_heads(const AttributeSet& set, const ArrayInfo& info,
                                                  const std::string& name) {
    std::vector<std::string> heads;
    const auto is_active = [&](const char* as) {
      const auto found = set.active.find(as);
      return found != set.active.end() && found->second == info.name;
    };
    if (is_active("Scalars")) {
      heads.push_back(fmt::format("SCALARS {} {} {}\nLOOKUP_TABLE default\n", name,
                                  type_name(info.type), info.components));
    }
    for (const WrittenAttribute& attribute : kWrittenAttributes) {
      if (!is_active(attribute.active)) continue;
      if (attribute.components == info.components) {
        heads.push_back(fmt::format("{} {} {}\n", attribute.word, name, type_name(info.type)));
      } else if (attribute.components == 0 && info.components <= 3) {
        heads.push_back(fmt::format("{} {} {} {}\n", attribute.word, name, info.components,
                                    type_name(info.type)));
      }
    }
    return heads;
  }

  template <class F>
  void put_attributes(const char* section, const AttributeSet& set, std::uint64_t tuples,
                      F put_rows) {
    if (set.arrays.empty()) return;
    put_text(fmt::format("{} {}\n", section, tuples), file_);
    std::vector<std::vector<std::string>> heads;
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      heads.push_back(attribute_heads(set, set.arrays[i], name_of(set.arrays[i], i)));
    }
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      const ArrayInfo& info = set.arrays[i];
      const auto put_array = [&](const std::string& head) {
        put_text(head, file_);
        put_rows(i);
        end_values();
        put_metadata(info);
      };
      for (const std::string& head : heads[i]) put_array(head);
      if (!heads[i].empty()) continue;
      if (i == 0 || !heads[i - 1].empty()) {
        std::size_t end = i;
        while (end < heads.size() && heads[end].empty()) ++end;
        put_text(fmt::format("FIELD FieldData {}\n", end - i), file_);
      }
      put_array(fmt::format("{} {} {} {}\n", name_of(info, i), info.components, tuples,
                            type_name(info.type)));
    }
  }

  static std::string name_of(const ArrayInfo& info, std::size_t index) {
    return info.name.empty() ? fmt::format("unnamed_{}", index) : encoded_name(info.name);
  }

  void put_metadata(const ArrayInfo& info) {
    if (info.component_names.empty() && info.units.empty()) return;
    std::string text = "METADATA\n";
    if (!info.component_names.empty()) text += "COMPONENT_NAMES\n";
    for (const std::string& name : info.component_names) text += encoded(name) + '\n';
    if (!info.units.empty()) {
      text += fmt::format("INFORMATION 1\nNAME {} LOCATION {}\nDATA {}\n", kUnitsKey,
                          kUnitsKeyClass, encoded(info.units));
    }
    put_text(text + '\n', file_);
  }

  void put_cell_rows(std::size_t index) {
    const ArrayInfo& info = mesh_.description().cell_data.arrays[index];
    mesh_.for_each_tets({index}, [&](std::uint64_t, const Vector<Tet>&,
                                     const std::vector<Vector<std::byte>>& rows) {
      put_values(info.type, info.components, rows[0]);
    });
    put_values(info.type, info.components, mesh_.lower_rows(index));
  }

  void put_point_rows(std::size_t index) {
    const ArrayInfo& info = mesh_.description().point_data.arrays[index];
    mesh_.for_each_point_rows(index, [&](std::uint64_t, const Vector<std::byte>& rows) {
      put_values(info.type, info.components, rows);
    });
  }

  // ---- field data ----

  void put_field_data() {
    const std::vector<ArrayInfo>& arrays = mesh_.description().field_data.arrays;
    if (arrays.empty()) return;
    put_text(fmt::format("FIELD FieldData {}\n", arrays.size()), file_);
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      const DataArray array = mesh_.read_field(i);
      const bool text = array.info.type == ValueType::kString;
      const auto strings = static_cast<std::uint64_t>(
          std::count(array.bytes.begin(), array.bytes.end(), std::byte{0}));
      put_text(
          fmt::format("{} {} {} {}\n", name_of(array.info, i), text ? 1 : array.info.components,
                      text ? strings : array.info.tuples, type_name(array.info.type)),
          file_);
      if (text) {
        put_strings(array);
      } else {
        put_values(array.info.type, array.info.components, array.bytes);
      }
      end_values();
      put_metadata(array.info);
    }
  }

  // Each ends with a zero byte.
  void put_strings(const DataArray& array) {
    std::string_view left(reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size());
    while (!left.empty()) {
      const std::string_view text = left.substr(0, left.find('\0'));
      left.remove_prefix(text.size() + 1);
      put_text(binary_ ? string_length(text.size()).append(text) : encoded(text) + '\n', file_);
    }
  }

  // In 1, 2, 4 or 8 bytes, whose first two bits say which.
  static std::string string_length(std::uint64_t length) {
    const unsigned kind = length < 1u << 6 ? 3 : length < 1u << 14 ? 2 : length < 1u << 30 ? 1 : 0;
    std::string bytes(std::size_t{8} >> kind, '\0');
    for (std::size_t i = bytes.size(); i-- > 0; length >>= 8) {
      bytes[i] = static_cast<char>(length & 0xFF);
    }
    bytes[0] = static_cast<char>(static_cast<unsigned char>(bytes[0]) | kind << 6);
    return bytes;
  }

  MeshPasses& mesh_;
  OutputFile* file_;
  bool binary_;
  Vector<std::byte> buffer_;
};

}  // namespace

void write_legacy_vtk(MeshPasses* mesh, OutputFile* file, bool binary,
                      const std::function<void(double)>& progress) {
  LegacyWriter(mesh, file, binary).run(progress);
}

}  // namespace tetfusion
