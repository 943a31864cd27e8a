#include "compare/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "base/blocks.h"
#include "mesh/regions/region_names.h"

namespace tetfusion {

namespace {

constexpr std::size_t kRowsPerBlock = 16384;

std::string describe(const ArrayInfo& info) {
  if (info.components == 1) return std::string(vtk_name(info.type));
  return fmt::format("{} x {}", vtk_name(info.type), info.components);
}

void match(const AttributeSet& original, const AttributeSet& simplified, std::string_view prefix,
           ArrayMatch* result, FieldSet* common) {
  for (std::size_t i = 0; i < original.arrays.size(); ++i) {
    const ArrayInfo& a = original.arrays[i];
    const std::string name = std::string(prefix) + a.name;
    const std::size_t other = simplified.find(a.name);
    const bool region =
        common == &result->cells && (looks_like_region(a) || is_region_of_floats(a));
    if (other == AttributeSet::npos) {
      result->missing.push_back(name);
      if (common == &result->points && is_float(a.type)) result->lost_fields.push_back(name);
      if (region) result->lost_regions.push_back(a.name);
      continue;
    }
    const ArrayInfo& b = simplified.arrays[other];
    if (common == &result->points && is_float(a.type) && a.components != b.components) {
      result->lost_fields.push_back(name);
    }
    if (region && a.components != b.components) result->lost_regions.push_back(a.name);
    if (a.type != b.type || a.components != b.components) {
      result->retyped.push_back({name, describe(a), describe(b)});
    }
    const bool text = a.type == ValueType::kString || b.type == ValueType::kString;
    // Of several arrays of one name the first one counts.
    if (common == nullptr || text || a.components != b.components || original.find(a.name) != i) {
      continue;
    }
    const bool integer = !is_float(a.type) && !is_float(b.type);
    common->fields.push_back({a, i, other, integer, region, common->components});
    common->components += a.components;
  }
}

}  // namespace

ArrayMatch match_arrays(const MeshDescription& original, const MeshDescription& simplified) {
  ArrayMatch result;
  match(original.point_data, simplified.point_data, "", &result, &result.points);
  match(original.cell_data, simplified.cell_data, "cell:", &result, &result.cells);
  match(original.field_data, simplified.field_data, "field:", &result, nullptr);
  result.cells.width = result.cells.components;
  result.points.width = result.points.components;
  for (Field& field : result.points.fields) field.length = result.points.width++;
  return result;
}

int exponent_for(double largest) {
  constexpr int kSquaresAreFine = 300, kMost = 1000;  // 2^kMost and 2^-kMost are normal numbers
  if (!(largest > 0)) return 0;
  const int exponent = std::ilogb(largest);
  return std::abs(exponent) <= kSquaresAreFine ? 0 : std::clamp(-exponent, -kMost, kMost);
}

namespace {

template <class T>
double difference(T value, WideInteger base) {
  if constexpr (std::is_floating_point_v<T>) {
    return value;
  } else {
    return static_cast<double>(WideInteger{value} - base);
  }
}

}  // namespace

void spread_values(const ArrayInfo& info, std::span<const std::byte> tuples,
                   const RowTarget& target) {
  visit_type(info.type, [&](auto zero) {
    using T = decltype(zero);
    for_each_block(
        target.rows, kRowsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            const std::size_t row = target.row_of.empty() ? i : target.row_of[i];
            double* to = target.out + i * target.width + target.offset;
            for (std::size_t c = 0; c < info.components; ++c) {
              T value;
              std::memcpy(&value, tuples.data() + (row * info.components + c) * sizeof(T),
                          sizeof value);
              to[c] = difference(value, target.base) * target.factor;
            }
          }
        });
  });
}

void fill_lengths(const FieldSet& fields, std::size_t rows, double* out) {
  for (std::size_t i = 0; i < rows; ++i, out += fields.width) {
    for (const Field& field : fields.fields) {
      out[field.length] = length_of(field, out + field.offset);
    }
  }
}

double rounding_of(ValueType type) {
  if (type == ValueType::kFloat32) return 4 * 0x1p-23;
  return type == ValueType::kFloat64 ? 4 * 0x1p-52 : 0;
}

}  // namespace tetfusion
