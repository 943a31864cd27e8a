// The errors of a simplified mesh at the points of the original, without any search structure.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "kernel/criteria.h"
#include "mesh/work_mesh.h"

namespace tetfusion::testing {

template <class Real>
std::array<double, 4> weights_in(const WorkMesh<Real>& mesh, const Tet& tet, const Vec3<Real>& p) {
  std::array<double, 4> weights{};
  double sum = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    Tet corners = tet;
    std::array<Vec3<Real>, 4> at{};
    for (std::size_t i = 0; i < 4; ++i) at[i] = i == c ? p : mesh.positions[corners[i]];
    weights[c] = determinant(at[0], at[1], at[2], at[3]).value;
    sum += weights[c];
  }
  for (double& w : weights) w /= sum;
  return weights;
}

// Of a field, as it is in the mesh's tetrahedron, from these values at p.
template <class Real>
double deviation_in(const WorkMesh<Real>& mesh, const Tet& tet, const Vec3<Real>& p,
                    const double* values, const SteeringField& field) {
  const auto weights = weights_in(mesh, tet, p);
  double square = 0;
  for (std::size_t k = field.first; k < field.first + field.count; ++k) {
    double difference = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      difference += weights[c] * (mesh.steering[tet[c] * mesh.steering_width + k] - values[k]);
    }
    square += difference * difference;
  }
  return std::sqrt(square) / field.range;
}

// May the tetrahedron hold the point, as far as boxes can tell?
template <class Real>
bool is_near(const WorkMesh<Real>& mesh, const Tet& tet, const Vec3<Real>& p) {
  const auto between = [&](auto Vec3<Real>::*axis) {
    const auto [lo, hi] = std::minmax({mesh.positions[tet[0]].*axis, mesh.positions[tet[1]].*axis,
                                       mesh.positions[tet[2]].*axis, mesh.positions[tet[3]].*axis});
    const Real room = (hi - lo) / 1000;
    return lo - room <= p.*axis && p.*axis <= hi + room;
  };
  return between(&Vec3<Real>::x) && between(&Vec3<Real>::y) && between(&Vec3<Real>::z);
}

// The largest one over all points of the original, in whatever tetrahedra hold them; infinite if
// nothing holds one.
template <class Real>
double worst_deviation(const WorkMesh<Real>& original, const WorkMesh<Real>& mesh,
                       const SteeringField& field) {
  double worst = 0;
  for (std::size_t v = 0; v < original.vertex_count(); ++v) {
    double here = -1;
    for (const Tet& tet : mesh.tets) {
      if (!is_near(mesh, tet, original.positions[v])) continue;
      const auto w = weights_in(mesh, tet, original.positions[v]);
      if (*std::min_element(w.begin(), w.end()) < -1e-12) continue;
      here = std::max(here,
                      deviation_in(mesh, tet, original.positions[v],
                                   original.steering.data() + v * original.steering_width, field));
    }
    if (here < 0) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, here);
  }
  return worst;
}

}  // namespace tetfusion::testing
