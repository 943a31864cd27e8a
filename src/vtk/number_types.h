// Types of numbers in arrays of VTK's.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkType.h>

#include <cstdint>
#include <type_traits>

namespace tetfusion {

// Calls f with a zero of the type that an array of this type of VTK's holds, one of those below.
template <class F>
decltype(auto) with_number_type(int vtk_type, F f) {
  switch (vtk_type) {
    case VTK_TYPE_INT8:
      return f(std::int8_t{0});
    case VTK_TYPE_UINT8:
      return f(std::uint8_t{0});
    case VTK_TYPE_INT16:
      return f(std::int16_t{0});
    case VTK_TYPE_UINT16:
      return f(std::uint16_t{0});
    case VTK_TYPE_INT32:
      return f(std::int32_t{0});
    case VTK_TYPE_UINT32:
      return f(std::uint32_t{0});
    case VTK_TYPE_INT64:
      return f(std::int64_t{0});
    case VTK_TYPE_UINT64:
      return f(std::uint64_t{0});
    case VTK_TYPE_FLOAT32:
      return f(float{0});
    default:
      return f(double{0});
  }
}

inline vtkSmartPointer<vtkDataArray> new_numbers(int vtk_type, std::uint64_t count) {
  auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(vtk_type));
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  return array;
}

// Of an array that new_numbers() made.
template <class T>
T* numbers_of(vtkDataArray* array) {
  return static_cast<T*>(array->GetVoidPointer(0));
}

// The number as an id; -1 where it is none, as negative, broken and far too large ones.
template <class T>
std::int64_t whole_number(T value) {
  constexpr std::int64_t kMost = std::int64_t{1} << 53;
  if constexpr (std::is_floating_point_v<T>) {
    if (!(value >= 0 && value <= static_cast<T>(kMost))) return -1;
    const auto id = static_cast<std::int64_t>(value);
    return static_cast<T>(id) == value ? id : -1;
  } else if constexpr (std::is_unsigned_v<T>) {
    return value > static_cast<std::uint64_t>(kMost) ? -1 : static_cast<std::int64_t>(value);
  } else {
    return value < 0 || static_cast<std::int64_t>(value) > kMost ? -1 : value;
  }
}

}  // namespace tetfusion
