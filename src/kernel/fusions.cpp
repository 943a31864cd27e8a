#include "kernel/fusions.h"

#include <algorithm>
#include <type_traits>

#include "kernel/criteria.h"

namespace tetfusion {

namespace {

template <class T>
void fuse_tuple(const Fusion& fusion, std::size_t components, T* values) {
  std::array<T*, 4> tuple{};
  for (std::size_t i = 0; i < 4; ++i) tuple[i] = values + fusion.vertices[i] * components;
  if constexpr (std::is_floating_point_v<T>) {
    for (std::size_t k = 0; k < components; ++k) {
      tuple[0][k] =
          static_cast<T>(mean_of_four(tuple[0][k], tuple[1][k], tuple[2][k], tuple[3][k]));
    }
  } else {
    std::copy_n(tuple[fusion.nearest], components, tuple[0]);
  }
}

template <class T>
void interpolate_tuple(const Interpolation& fusion, std::size_t components, T* values) {
  T* to = values + fusion.to * components;
  if constexpr (std::is_floating_point_v<T>) {
    for (std::size_t k = 0; k < components; ++k) {
      to[k] = static_cast<T>(interpolate(fusion, values, components, k));
    }
  } else {
    std::copy_n(values + fusion.nearest * components, components, to);
  }
}

}  // namespace

void interpolate_point_column(std::span<const Interpolation> fusions, Column* column) {
  visit_type(column->type, [&](auto zero) {
    using T = decltype(zero);
    T* values = reinterpret_cast<T*>(column->rows.data());
    for (const Interpolation& fusion : fusions) {
      interpolate_tuple(fusion, column->components, values);
    }
  });
}

void carry_point_column(std::span<const Fusion> fusions, Column* column) {
  visit_type(column->type, [&](auto zero) {
    using T = decltype(zero);
    T* values = reinterpret_cast<T*>(column->rows.data());
    for (const Fusion& fusion : fusions) fuse_tuple(fusion, column->components, values);
  });
}

}  // namespace tetfusion
