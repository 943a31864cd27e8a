// A point in a tetrahedron: the shares of its corners.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
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

// The same for all corners.
class CornerVolumes {
 public:
  CornerVolumes(const Corners& corners, const Point& p) {
    for (std::size_t i = 0; i < 4; ++i) from_p_[i] = corners[i] - p;
    const Point first = cross(from_p_[0], from_p_[1]), last = cross(from_p_[2], from_p_[3]);
    values_ = {dot(from_p_[1], last), -dot(from_p_[0], last), dot(from_p_[3], first),
               -dot(from_p_[2], first)};
  }

  const std::array<double, 4>& values() const { return values_; }
  // The point lies inside. Of a point that is far away, beside the corners' distances from each
  // other, not all are positive, but of none it is certain what it is: its box tells.
  bool are_positive() const {
    const auto& v = values_;
    return std::min(std::min(v[0], v[1]), std::min(v[2], v[3])) > 0;
  }
  // Whether the point is certainly beyond the face opposite to the corner.
  bool beyond(std::size_t corner) const {
    // Most corners are done here, without a bound on the error.
    return !(values_[corner] >= 0) && !(values_[corner] >= -error(corner));
  }
  // The corner opposite to a face beyond which the point certainly lies, mostly the one with the
  // most volume between it and the point; kNone if there is none.
  std::size_t exit() const {
    const auto& v = values_;
    const std::size_t first = v[1] < v[0] ? 1 : 0, last = v[3] < v[2] ? 3 : 2;
    const std::size_t least = v[last] < v[first] ? last : first;
    const bool overflow = std::isnan((v[0] + v[1]) + (v[2] + v[3]));
    if (v[least] >= 0 && !overflow) return kNone;
    if (beyond(least)) return least;
    std::size_t corner = 0;
    while (corner < kNone && !beyond(corner)) ++corner;
    return corner;
  }
  static constexpr std::size_t kNone = 4;

 private:
  double error(std::size_t corner) const {
    const std::size_t partner = corner ^ 1, pair = 2 - (corner & 2);  // the others: pair, pair + 1
    return determinant_error(largest_part(from_p_[pair]), largest_part(from_p_[pair + 1]),
                             largest_part(from_p_[partner]));
  }

  std::array<Point, 4> from_p_;
  std::array<double, 4> values_;
};

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

// Whether the point lies in the box round the corners.
inline bool box_holds(const Corners& corners, const Point& p) {
  const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x, corners[3].x});
  const auto [front, back] = std::minmax({corners[0].y, corners[1].y, corners[2].y, corners[3].y});
  const auto [low, high] = std::minmax({corners[0].z, corners[1].z, corners[2].z, corners[3].z});
  return left <= p.x && p.x <= right && front <= p.y && p.y <= back && low <= p.z && p.z <= high;
}

// None if the point is certainly beyond one of the faces.
inline std::optional<std::array<double, 4>> weights_in(const Corners& corners, const Point& p) {
  const CornerVolumes volumes(corners, p);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    if (volumes.beyond(corner)) return std::nullopt;
  }
  if (!volumes.are_positive() && !box_holds(corners, p)) return std::nullopt;
  return weights_of(volumes.values());
}

}  // namespace tetfusion
