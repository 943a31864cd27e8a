// A mesh's time, as VTK has it: a field array of one number.
#pragma once

#include <optional>

#include "mesh/data_array.h"

namespace tetfusion {

inline constexpr const char* kTimeValue = "TimeValue";

inline bool is_time_value(const ArrayInfo& field) {
  return field.name == kTimeValue && field.values() == 1 && field.type != ValueType::kString;
}

// None: the array is something else.
inline std::optional<double> time_of(const DataArray& field) {
  if (!is_time_value(field.info)) return {};
  return to_doubles(field.info.type, field.bytes)[0];
}

}  // namespace tetfusion
