// A point in a tetrahedron: the shares of its corners.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "compare/point.h"
#include "mesh/faces.h"
#include "mesh/predicates.h"

namespace tetfusion {

// Six times the volume between the point and the face opposite to the corner: negative if the point
// lies beyond it. The corners are wound as VTK winds them.
inline Determinant volume_at(const Corners& corners, std::size_t corner, const Point& p) {
  const auto& face = kFaceCorners[corner];
  return determinant(p, corners[face[0]], corners[face[1]], corners[face[2]]);
}

// The same for all corners at once.
inline std::array<Determinant, 4> volumes_at(const Corners& corners, const Point& p) {
  std::array<Point, 4> q;
  std::array<double, 4> largest;
  for (std::size_t i = 0; i < 4; ++i) {
    q[i] = corners[i] - p;
    largest[i] = largest_part(q[i]);
  }
  const Point first = cross(q[0], q[1]), last = cross(q[2], q[3]);
  const auto error = [&](std::size_t u, std::size_t v, std::size_t w) {
    return determinant_error(largest[u], largest[v], largest[w]);
  };
  return {{{dot(q[1], last), error(2, 3, 1)},
           {-dot(q[0], last), error(2, 3, 0)},
           {dot(q[3], first), error(0, 1, 3)},
           {-dot(q[2], first), error(0, 1, 2)}}};
}

// Weights, 0 to 1 with sum 1, of shares that may be a little negative, by rounding.
inline std::array<double, 4> weights_of(std::array<double, 4> shares) {
  double sum = 0;
  for (double& share : shares) {
    share = std::max(share, 0.0);
    sum += share;
  }
  for (double& share : shares) share = sum > 0 ? share / sum : 0.25;
  return shares;
}

// None if the point is certainly beyond one of the faces.
inline std::optional<std::array<double, 4>> weights_in(const Corners& corners, const Point& p) {
  const std::array<Determinant, 4> volumes = volumes_at(corners, p);
  std::array<double, 4> shares;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const Determinant& d = volumes[corner];
    if (d.value < -d.error) return std::nullopt;
    shares[corner] = d.value;
  }
  return weights_of(shares);
}

}  // namespace tetfusion
