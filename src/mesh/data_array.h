// Named arrays over points, cells or the whole data set, in VTK's words: tuples of components.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/vector.h"

namespace tetfusion {

enum class ValueType : std::uint8_t {
  kInt8,
  kUInt8,
  kInt16,
  kUInt16,
  kInt32,
  kUInt32,
  kInt64,
  kUInt64,
  kFloat32,
  kFloat64,
  kString  // field data only: the bytes of all strings, each ended by a zero byte
};

std::size_t size_of(ValueType type);        // bytes of one value; 1 for kString
std::string_view vtk_name(ValueType type);  // "Float32", "Int64", "String", ...
bool parse_vtk_type(std::string_view name, ValueType* type);
inline bool is_float(ValueType t) { return t == ValueType::kFloat32 || t == ValueType::kFloat64; }

template <class T>
constexpr ValueType value_type_of();
template <>
constexpr ValueType value_type_of<std::int8_t>() {
  return ValueType::kInt8;
}
template <>
constexpr ValueType value_type_of<std::uint8_t>() {
  return ValueType::kUInt8;
}
template <>
constexpr ValueType value_type_of<std::int16_t>() {
  return ValueType::kInt16;
}
template <>
constexpr ValueType value_type_of<std::uint16_t>() {
  return ValueType::kUInt16;
}
template <>
constexpr ValueType value_type_of<std::int32_t>() {
  return ValueType::kInt32;
}
template <>
constexpr ValueType value_type_of<std::uint32_t>() {
  return ValueType::kUInt32;
}
template <>
constexpr ValueType value_type_of<std::int64_t>() {
  return ValueType::kInt64;
}
template <>
constexpr ValueType value_type_of<std::uint64_t>() {
  return ValueType::kUInt64;
}
template <>
constexpr ValueType value_type_of<float>() {
  return ValueType::kFloat32;
}
template <>
constexpr ValueType value_type_of<double>() {
  return ValueType::kFloat64;
}

// Calls f(T{}) with T the C++ type of `type`. kString is visited as uint8_t.
template <class F>
decltype(auto) visit_type(ValueType type, F&& f) {
  switch (type) {
    case ValueType::kInt8:
      return f(std::int8_t{});
    case ValueType::kString:
    case ValueType::kUInt8:
      return f(std::uint8_t{});
    case ValueType::kInt16:
      return f(std::int16_t{});
    case ValueType::kUInt16:
      return f(std::uint16_t{});
    case ValueType::kInt32:
      return f(std::int32_t{});
    case ValueType::kUInt32:
      return f(std::uint32_t{});
    case ValueType::kInt64:
      return f(std::int64_t{});
    case ValueType::kUInt64:
      return f(std::uint64_t{});
    case ValueType::kFloat32:
      return f(float{});
    case ValueType::kFloat64:
      return f(double{});
  }
  throw std::logic_error("unknown ValueType");
}

enum class Association : std::uint8_t { kPoint, kCell, kField };

// Values of a type as doubles.
Vector<double> to_doubles(ValueType type, std::span<const std::byte> values);

// Of a floating-point type: are they anything but whole numbers, which may be labels? Large ones
// are all whole, and no labels, as not all of these could be told apart.
bool has_fractions(ValueType type, std::span<const std::byte> values);

// VTK's key that ArrayInfo::units are stored under, and the class that it is of: what else is in an
// array's information are ranges that VTK keeps for itself, and the like.
inline constexpr std::string_view kUnitsKey = "UNITS_LABEL";
inline constexpr std::string_view kUnitsKeyClass = "vtkDataArray";

// What is known of an array without reading its values.
struct ArrayInfo {
  std::string name;
  ValueType type = ValueType::kFloat32;
  std::uint32_t components = 1;
  std::vector<std::string> component_names;  // empty, or one a component
  std::uint64_t tuples = 0;                  // all pieces together
  bool steers_only = false;  // there for a run to be steered by: not in what it makes of the mesh
  std::string units = {};    // "m/s", as anybody writes them; empty: nobody says

  std::uint64_t values() const { return tuples * components; }
  std::uint64_t row_bytes() const { return components * size_of(type); }  // of a tuple
  std::uint64_t bytes() const { return tuples * row_bytes(); }
};

// The arrays of one association, in file order, and VTK's active-attribute markers:
// {"Scalars": "Density", "Vectors": "Momentum", "GlobalIds": "GlobalNodeId", ...}.
struct AttributeSet {
  std::vector<ArrayInfo> arrays;
  std::map<std::string, std::string> active;

  // Index of the array of that name, or npos.
  static constexpr std::size_t npos = std::numeric_limits<std::size_t>::max();
  std::size_t find(std::string_view name) const;
  // What all arrays take, and what they take for a point, or a cell.
  std::uint64_t bytes() const {
    std::uint64_t bytes = 0;
    for (const ArrayInfo& info : arrays) bytes += info.bytes();
    return bytes;
  }
  std::uint64_t row_bytes() const {
    std::uint64_t bytes = 0;
    for (const ArrayInfo& info : arrays) bytes += info.row_bytes();
    return bytes;
  }
};

// An array with its values, in native byte order.
struct DataArray {
  ArrayInfo info;
  Vector<std::byte> bytes;  // info.bytes(); for kString the raw bytes

  template <class T>
  std::span<T> as() {
    return {reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T)};
  }
  template <class T>
  std::span<const T> as() const {
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
  }
};

// Its strings; of another array than one of strings, none.
std::vector<std::string> texts_of(const DataArray& array);

}  // namespace tetfusion
