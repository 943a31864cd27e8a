// What a pass did, as a list, so that arrays which do not steer can follow afterwards.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "kernel/criteria.h"
#include "mesh/geometry.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// One TetFuse: four vertices become one, which goes on as the first one.
struct Fusion {
  std::array<VertexId, 4> vertices;
  std::uint8_t nearest;  // which of the four was nearest to the fused one
};

// Two vertices or more become one, somewhere in a tetrahedron of the old cavity.
struct Interpolation {
  VertexId to = 0;  // the vertex that goes on
  Tet from{};       // the tetrahedron's vertices
  std::array<double, 4> weights{};
  VertexId nearest = 0;  // of those that were fused
};

// The mean of the values that are finite, if these have half of the weight; else one that is not.
double mean_of_finite(const std::array<double, 4>& values, const std::array<double, 4>& weights);

// Component k there, of rows of so many. A constant stays the same to the bit, and the value is one
// between those of the four, or of those that are finite.
template <class T>
double interpolate(const Interpolation& fusion, const T* rows, std::size_t components,
                   std::size_t k) {
  const auto at = [&](std::size_t i) { return double{rows[fusion.from[i] * components + k]}; };
  const double first = at(0);
  double value = first, least = first, most = first;
  for (std::size_t i = 1; i < 4; ++i) {
    value += fusion.weights[i] * (at(i) - first);
    least = std::min(least, at(i));
    most = std::max(most, at(i));
  }
  if (!std::isfinite(value)) {
    return mean_of_finite({first, at(1), at(2), at(3)}, fusion.weights);
  }
  return std::min(std::max(value, least), most);
}

// Gives each fused vertex the value of the old cavity's piecewise-linear interpolant at its place,
// in which values that are not finite only count where they have more than half of the weight;
// integers take the nearest fused vertex's. In the order of the list, as later ones may stand on
// earlier ones.
void interpolate_point_column(std::span<const Interpolation> fusions, Column* column);

// Gives each fused vertex the value that the old cavity's piecewise-linear interpolant has at the
// barycenter of the prey: the mean of its four values, or of those that are finite, if there are
// two; integers take the nearest vertex's. The rows of the first vertices are overwritten. No
// fusion may name a vertex that an earlier one names.
void carry_point_column(std::span<const Fusion> fusions, Column* column);

// Does the field steer by a floating-point column of points?
template <class Real>
bool is_column(const SteeringField& field, const WorkMesh<Real>& mesh) {
  return field.column != kNoColumn && is_float(mesh.point_columns[field.column].type);
}

// Gives these vertices, in the columns that do so, their steering values.
template <class Real>
void write_steering_columns(std::span<const SteeringField> fields,
                            std::span<const VertexId> vertices, WorkMesh<Real>* mesh);

}  // namespace tetfusion
