#include "kernel/fusions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace tetfusion {

namespace {

constexpr std::array<double, 4> kAlike{0.25, 0.25, 0.25, 0.25};

template <class T>
void fuse_tuple(const Fusion& fusion, std::size_t components, T* values) {
  std::array<T*, 4> tuple{};
  for (std::size_t i = 0; i < 4; ++i) tuple[i] = values + fusion.vertices[i] * components;
  if constexpr (std::is_floating_point_v<T>) {
    for (std::size_t k = 0; k < components; ++k) {
      const double mean = mean_of_four(tuple[0][k], tuple[1][k], tuple[2][k], tuple[3][k]);
      tuple[0][k] = static_cast<T>(
          std::isfinite(mean)
              ? mean
              : mean_of_finite({tuple[0][k], tuple[1][k], tuple[2][k], tuple[3][k]}, kAlike));
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

double mean_of_finite(const std::array<double, 4>& values, const std::array<double, 4>& weights) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double sum = 0, weight = 0, other = std::numeric_limits<double>::quiet_NaN();
  double least = kInfinity, most = -kInfinity;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!std::isfinite(values[i])) {
      other = values[i];
    } else if (weights[i] > 0) {
      weight += weights[i];
      sum += weights[i] * values[i];
      least = std::min(least, values[i]);
      most = std::max(most, values[i]);
    }
  }
  return weight >= 0.5 ? std::clamp(sum / weight, least, most) : other;
}

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

template <class Real>
void write_steering_columns(std::span<const SteeringField> fields,
                            std::span<const VertexId> vertices, WorkMesh<Real>* mesh) {
  for (const SteeringField& f : fields) {
    if (!is_column(f, *mesh)) continue;
    Column& column = mesh->point_columns[f.column];
    visit_type(column.type, [&](auto zero) {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>) {
        T* values = reinterpret_cast<T*>(column.rows.data());
        for (const VertexId v : vertices) {
          const double* from =
              mesh->steering.data() + std::size_t{v} * mesh->steering_width + f.first;
          for (std::uint32_t k = 0; k < f.count; ++k) {
            values[std::size_t{v} * f.count + k] = static_cast<T>(std::ldexp(from[k], -f.exponent));
          }
        }
      }
    });
  }
}

template void write_steering_columns(std::span<const SteeringField>, std::span<const VertexId>,
                                     WorkMesh<float>*);
template void write_steering_columns(std::span<const SteeringField>, std::span<const VertexId>,
                                     WorkMesh<double>*);

}  // namespace tetfusion
