#include "vtk/vtk_arrays.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <type_traits>

#include "base/error.h"
#include "base/numbers.h"
#include "vtk/versions/vtk_versions.h"

namespace tetfusion {
namespace {

template <std::size_t kBytes, bool kSigned>
constexpr ValueType integer_type() {
  static_assert(kBytes == 1 || kBytes == 2 || kBytes == 4 || kBytes == 8);
  if constexpr (kBytes == 1) return kSigned ? ValueType::kInt8 : ValueType::kUInt8;
  if constexpr (kBytes == 2) return kSigned ? ValueType::kInt16 : ValueType::kUInt16;
  if constexpr (kBytes == 4) return kSigned ? ValueType::kInt32 : ValueType::kUInt32;
  return kSigned ? ValueType::kInt64 : ValueType::kUInt64;
}

std::optional<ValueType> value_type(const vtkAbstractArray* array) {
  switch (array->GetDataType()) {
    case VTK_FLOAT:
      return ValueType::kFloat32;
    case VTK_DOUBLE:
      return ValueType::kFloat64;
    case VTK_BIT:
      return ValueType::kUInt8;  // a byte each
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return ValueType::kInt8;
    case VTK_UNSIGNED_CHAR:
      return ValueType::kUInt8;
    case VTK_SHORT:
      return integer_type<sizeof(short), true>();
    case VTK_UNSIGNED_SHORT:
      return integer_type<sizeof(short), false>();
    case VTK_INT:
      return integer_type<sizeof(int), true>();
    case VTK_UNSIGNED_INT:
      return integer_type<sizeof(int), false>();
    case VTK_LONG:
      return integer_type<sizeof(long), true>();
    case VTK_UNSIGNED_LONG:
      return integer_type<sizeof(long), false>();
    case VTK_LONG_LONG:
      return integer_type<sizeof(long long), true>();
    case VTK_UNSIGNED_LONG_LONG:
      return integer_type<sizeof(long long), false>();
    case VTK_ID_TYPE:
      return integer_type<sizeof(vtkIdType), true>();
    case VTK_STRING:
      return ValueType::kString;
    default:
      return std::nullopt;
  }
}

bool is_ghost_array(const std::string& name) {
  return name == vtkDataSetAttributes::GhostArrayName();
}

std::string name_of(vtkAbstractArray* array, int index) {
  const char* name = array->GetName();
  return name != nullptr && *name != '\0' ? name : "array_" + std::to_string(index);
}

vtkDataSetAttributes* attributes_of(const Piece& piece, Association association) {
  if (association == Association::kPoint) return piece.data->GetPointData();
  return piece.data->GetCellData();
}

std::uint64_t rows_of(const Piece& piece, Association association) {
  return association == Association::kPoint ? piece.points() : piece.cells();
}

ArrayInfo describe(vtkAbstractArray* array, const std::string& name, ValueType type) {
  ArrayInfo info;
  info.name = name;
  info.type = type;
  info.components = static_cast<std::uint32_t>(array->GetNumberOfComponents());
  info.tuples = static_cast<std::uint64_t>(array->GetNumberOfTuples());
  if (array->HasAComponentName()) {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c) {
      const char* component = array->GetComponentName(c);
      info.component_names.emplace_back(component != nullptr ? component : "");
    }
  }
  if (array->HasInformation()) {
    const char* units = array->GetInformation()->Get(vtkDataArray::UNITS_LABEL());
    if (units != nullptr) info.units = units;
  }
  return info;
}

bool is_signed(ValueType type) {
  return visit_type(type, [](auto zero) { return std::is_signed_v<decltype(zero)>; });
}

// That has all values of both.
std::optional<ValueType> common_type(ValueType a, ValueType b) {
  const ValueType narrow = size_of(a) < size_of(b) ? a : b, wide = narrow == a ? b : a;
  if (narrow == wide) return wide;
  if (is_float(narrow) != is_float(wide)) return std::nullopt;
  const bool has_all = is_signed(wide) || !is_signed(narrow);
  return has_all && size_of(narrow) < size_of(wide) ? std::optional(wide) : std::nullopt;
}

// Notes one more part of an array; its type becomes one that all parts have room in.
void add_part(const std::string& path, const std::string& what, vtkAbstractArray* part,
              std::uint64_t rows, ArrayInfo* whole) {
  if (static_cast<std::uint64_t>(part->GetNumberOfTuples()) != rows) {
    throw Error(ErrorCode::kBadInput, path + ": " + what + " has " +
                                          std::to_string(part->GetNumberOfTuples()) +
                                          " tuples for " + std::to_string(rows) + " rows");
  }
  const ValueType type = *value_type(part);
  const auto components = static_cast<std::uint32_t>(part->GetNumberOfComponents());
  const auto common = common_type(type, whole->type);
  if (!common || components != whole->components) {
    const auto form = [](ValueType t, std::uint32_t n) {
      return std::string(vtk_name(t)) + " with " + format_count(n, "component");
    };
    throw Error(ErrorCode::kBadInput, path + ": " + what + " is " +
                                          form(whole->type, whole->components) +
                                          " in one block and " + form(type, components) +
                                          " in another: give them one type, or other names");
  }
  whole->type = *common;
}

void collect_active(vtkDataSetAttributes* attributes, AttributeSet* set) {
  for (int kind = 0; kind < vtkDataSetAttributes::NUM_ATTRIBUTES; ++kind) {
    vtkAbstractArray* array = attributes->GetAbstractAttribute(kind);
    if (array == nullptr || array->GetName() == nullptr) continue;
    if (set->find(array->GetName()) == AttributeSet::npos) continue;
    set->active.emplace(vtkDataSetAttributes::GetAttributeTypeAsString(kind), array->GetName());
  }
}

std::string leaves_out(const char* kind, const std::string& name, vtkAbstractArray* array) {
  return std::string(kind) + " array '" + name + "' (" + array->GetDataTypeAsString() + ")";
}

// Of each piece of the list its place among those that bring rows: where it brings no points, that
// of the piece that has brought them.
std::vector<std::size_t> places_of(const PieceList& list, Association association) {
  std::vector<std::size_t> places;
  std::map<std::uint64_t, std::size_t> with_points;  // by the first one's number
  std::size_t next = 0;
  for (const Piece& piece : list.pieces) {
    const bool brings = association == Association::kCell || piece.brings_points;
    places.push_back(brings ? next++ : with_points.at(piece.first_point));
    if (brings && piece.points() > 0) with_points.emplace(piece.first_point, places.back());
  }
  return places;
}

void append_strings(vtkStringArray* strings, Vector<std::byte>* out) {
  for (vtkIdType i = 0; i < strings->GetNumberOfValues(); ++i) {
    const std::string value = strings->GetValue(i);
    const auto* from = reinterpret_cast<const std::byte*>(value.c_str());
    out->insert(out->end(), from, from + std::strlen(value.c_str()) + 1);
  }
}

// Copies a part's values to `to`, which has room for them, as numbers of that type.
void copy_values(vtkDataArray* part, ValueType type, std::byte* to) {
  const auto values = static_cast<std::uint64_t>(part->GetNumberOfValues());
  if (values == 0) return;
  if (part->GetDataType() == VTK_BIT) {
    const int width = part->GetNumberOfComponents();
    visit_type(type, [&](auto zero) {
      auto* out = reinterpret_cast<decltype(zero)*>(to);
      for (vtkIdType i = 0; i < part->GetNumberOfTuples(); ++i) {
        for (int c = 0; c < width; ++c)
          *out++ = static_cast<decltype(zero)>(part->GetComponent(i, c));
      }
    });
    return;
  }
  vtkSmartPointer<vtkDataArray> array = part;
  if (!part->HasStandardMemoryLayout()) array = vtk_version::in_standard_layout(part);
  const void* from = array->GetVoidPointer(0);
  const ValueType own = *value_type(part);
  if (own == type) {
    std::memcpy(to, from, values * size_of(type));
    return;
  }
  visit_type(own, [&](auto own_zero) {
    visit_type(type, [&](auto zero) {
      const auto convert = [](auto value) { return static_cast<decltype(zero)>(value); };
      const auto* begin = static_cast<const decltype(own_zero)*>(from);
      std::transform(begin, begin + values, reinterpret_cast<decltype(zero)*>(to), convert);
    });
  });
}

void fill_missing(ValueType type, std::byte* to, std::uint64_t values) {
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    // The quiet NaN of an integer type is 0.
    std::fill_n(reinterpret_cast<T*>(to), values, std::numeric_limits<T>::quiet_NaN());
  });
}

// The first copy that has a value gives it to the point that stays, and this to the others.
void fill_from_copies(const PieceList& list, const std::vector<vtkAbstractArray*>& parts,
                      const Vector<VertexId>& copy_of, DataArray* out) {
  Vector<std::uint8_t> known(copy_of.size(), std::uint8_t{0});
  const auto pieces = pieces_with_rows(list, Association::kPoint);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Piece& piece = *pieces[k];
    if (parts[k] != nullptr) std::fill_n(known.data() + piece.first_point, piece.points(), 1);
  }
  const std::size_t tuple = out->info.row_bytes();
  const auto give = [&](std::size_t from, std::size_t to) {
    if (known[from] == 0 || known[to] != 0) return;
    std::memcpy(out->bytes.data() + to * tuple, out->bytes.data() + from * tuple, tuple);
    known[to] = 1;
  };
  for (std::size_t v = 0; v < copy_of.size(); ++v) give(v, copy_of[v]);
  for (std::size_t v = 0; v < copy_of.size(); ++v) give(copy_of[v], v);
}

bool have_same_values(vtkAbstractArray* a, vtkAbstractArray* b) {
  if (a->GetNumberOfValues() != b->GetNumberOfValues()) return false;
  for (vtkIdType i = 0; i < a->GetNumberOfValues(); ++i) {
    if (a->GetVariantValue(i) != b->GetVariantValue(i)) return false;
  }
  return true;
}

}  // namespace

ArrayTable collect_arrays(const std::string& path, const PieceList& list, Association association) {
  const bool points = association == Association::kPoint;
  const char* kind = points ? "point" : "cell";
  ArrayTable table;
  const std::size_t with_rows = pieces_with_rows(list, association).size();
  const std::vector<std::size_t> places = places_of(list, association);
  for (std::size_t p = 0; p < list.pieces.size(); ++p) {
    const Piece& piece = list.pieces[p];
    vtkDataSetAttributes* attributes = attributes_of(piece, association);
    for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
      vtkAbstractArray* array = attributes->GetAbstractArray(i);
      const std::string name = name_of(array, i);
      if (is_ghost_array(name)) continue;
      const auto type = value_type(array);
      if (!type || *type == ValueType::kString || array->GetNumberOfComponents() < 1) {
        if (!points || piece.brings_points) {
          table.left_out.push_back(leaves_out(kind, name, array));
        }
        continue;
      }
      std::size_t at = table.set.find(name);
      if (at == AttributeSet::npos) {
        at = table.set.arrays.size();
        table.set.arrays.push_back(describe(array, name, *type));
        table.set.arrays.back().tuples = points ? list.points : list.cells;
        table.parts.emplace_back(with_rows, nullptr);
      }
      vtkAbstractArray*& part = table.parts[at][places[p]];
      if (part != nullptr) continue;  // of points that an earlier piece has brought
      add_part(path, std::string(kind) + " array '" + name + "'", array,
               rows_of(piece, association), &table.set.arrays[at]);
      part = array;
    }
    collect_active(attributes, &table.set);
  }
  return table;
}

ArrayTable collect_field_data(const std::vector<vtkSmartPointer<vtkFieldData>>& fields) {
  ArrayTable table;
  std::set<std::string> differing;
  for (const auto& field : fields) {
    if (field == nullptr) continue;
    for (int i = 0; i < field->GetNumberOfArrays(); ++i) {
      vtkAbstractArray* array = field->GetAbstractArray(i);
      const std::string name = name_of(array, i);
      if (is_ghost_array(name)) continue;
      if (const std::size_t at = table.set.find(name); at != AttributeSet::npos) {
        if (!have_same_values(table.parts[at][0], array)) differing.insert(name);
        continue;
      }
      const auto type = value_type(array);
      if (!type || array->GetNumberOfComponents() < 1) {
        table.left_out.push_back(leaves_out("field", name, array));
        continue;
      }
      table.set.arrays.push_back(describe(array, name, *type));
      table.parts.push_back({array});
    }
  }
  for (const std::string& name : differing) {
    table.left_out.push_back("other values of field array '" + name + "' in later blocks");
  }
  return table;
}

bool some_piece_lacks(const ArrayTable& table, std::size_t index) {
  const auto& parts = table.parts.at(index);
  return std::find(parts.begin(), parts.end(), nullptr) != parts.end();
}

DataArray read_values(const PieceList& list, const ArrayTable& table, Association association,
                      std::size_t index, const Vector<VertexId>& copy_of) {
  DataArray out;
  out.info = table.set.arrays.at(index);
  const auto& parts = table.parts[index];
  if (out.info.type == ValueType::kString) {
    append_strings(vtkStringArray::SafeDownCast(parts[0]), &out.bytes);
    return out;
  }
  out.bytes.resize(out.info.bytes());
  if (association == Association::kField) {
    copy_values(vtkDataArray::SafeDownCast(parts[0]), out.info.type, out.bytes.data());
    return out;
  }
  const auto pieces = pieces_with_rows(list, association);
  std::byte* to = out.bytes.data();
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::uint64_t values = rows_of(*pieces[k], association) * out.info.components;
    if (vtkAbstractArray* part = parts[k]) {
      copy_values(vtkDataArray::SafeDownCast(part), out.info.type, to);
    } else {
      fill_missing(out.info.type, to, values);
    }
    to += values * size_of(out.info.type);
  }
  if (!copy_of.empty() && some_piece_lacks(table, index)) {
    fill_from_copies(list, parts, copy_of, &out);
  }
  return out;
}

CopyDifferences find_differences(const PieceList& list, const ArrayTable& points,
                                 const Vector<VertexId>& copy_of,
                                 const Vector<std::uint8_t>& used) {
  if (copy_of.empty()) return {};
  DataArray values;  // of the array that was last asked for
  std::size_t read = AttributeSet::npos;
  return find_differences(copy_of, used, points.set.arrays,
                          [&](std::size_t array, std::uint64_t first,
                              std::uint64_t count) -> std::span<const std::byte> {
                            if (array != read)
                              values =
                                  read_values(list, points, Association::kPoint, array, copy_of);
                            read = array;
                            const std::size_t row = values.info.row_bytes();
                            return std::span(values.bytes).subspan(first * row, count * row);
                          });
}

}  // namespace tetfusion
