#include "mesh/data_array.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/numbers.h"

namespace tetfusion {

namespace {
struct TypeName {
  ValueType type;
  std::string_view name;
  std::size_t size;
};
constexpr std::array<TypeName, 11> kTypes{{{ValueType::kInt8, "Int8", 1},
                                           {ValueType::kUInt8, "UInt8", 1},
                                           {ValueType::kInt16, "Int16", 2},
                                           {ValueType::kUInt16, "UInt16", 2},
                                           {ValueType::kInt32, "Int32", 4},
                                           {ValueType::kUInt32, "UInt32", 4},
                                           {ValueType::kInt64, "Int64", 8},
                                           {ValueType::kUInt64, "UInt64", 8},
                                           {ValueType::kFloat32, "Float32", 4},
                                           {ValueType::kFloat64, "Float64", 8},
                                           {ValueType::kString, "String", 1}}};
}  // namespace

std::size_t size_of(ValueType type) { return kTypes[static_cast<std::size_t>(type)].size; }

std::string_view vtk_name(ValueType type) { return kTypes[static_cast<std::size_t>(type)].name; }

bool parse_vtk_type(std::string_view name, ValueType* type) {
  for (const TypeName& t : kTypes) {
    if (t.name == name) {
      *type = t.type;
      return true;
    }
  }
  return false;
}

Vector<double> to_doubles(ValueType type, std::span<const std::byte> values) {
  Vector<double> out(values.size() / size_of(type));
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    for (std::size_t i = 0; i < out.size(); ++i) {
      T value;
      std::memcpy(&value, values.data() + i * sizeof(T), sizeof(T));
      out[i] = static_cast<double>(value);
    }
  });
  return out;
}

namespace {

template <class T>
bool has_fraction(std::span<const std::byte> bytes) {
  constexpr T kMostLabel = static_cast<T>(std::uint64_t{1} << std::numeric_limits<T>::digits);
  const auto* const values = reinterpret_cast<const T*>(bytes.data());
  return std::any_of(values, values + bytes.size() / sizeof(T), [](T value) {
    return std::isfinite(value) && (value != std::trunc(value) || std::abs(value) >= kMostLabel);
  });
}

}  // namespace

bool has_fractions(ValueType type, std::span<const std::byte> values) {
  return type == ValueType::kFloat32 ? has_fraction<float>(values) : has_fraction<double>(values);
}

std::size_t AttributeSet::find(std::string_view name) const {
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (arrays[i].name == name) return i;
  }
  return npos;
}

std::vector<std::string> texts_of(const DataArray& array) {
  if (array.info.type != ValueType::kString) return {};
  const std::string_view all(reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size());
  std::vector<std::string> texts = split(all, '\0');
  if (!texts.empty()) texts.pop_back();  // each ends with a zero
  return texts;
}

}  // namespace tetfusion
