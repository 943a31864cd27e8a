// The volume that two tetrahedra have in common.
#pragma once

#include <array>
#include <cstddef>

#include "base/lanes.h"
#include "mesh/geometry.h"

namespace tetfusion {

using TetCorners = std::array<Vec3<double>, 4>;

// The points x with normal . (x - at) >= 0.
struct HalfSpace {
  Vec3<double> at, normal;
  double height(const Vec3<double>& x) const {
    return normal.x * (x.x - at.x) + normal.y * (x.y - at.y) + normal.z * (x.z - at.z);
  }
  // Of four points, given axis by axis.
  std::array<DoubleLanes, 2> heights(const std::array<std::array<DoubleLanes, 2>, 3>& p) const {
    std::array<DoubleLanes, 2> all;
    for (std::size_t i = 0; i < 2; ++i) {
      all[i] =
          normal.x * (p[0][i] - at.x) + normal.y * (p[1][i] - at.y) + normal.z * (p[2][i] - at.z);
    }
    return all;
  }
};

// A tetrahedron of positive volume, ready to be held against many others.
class OverlapTet {
 public:
  // `origin` is a place near it: about that nothing is rounded to units of places far away.
  OverlapTet(const TetCorners& corners, const Vec3<double>& origin);

  // Six times the common volume, as the determinant of a tetrahedron is. Exact but for rounding of
  // the order of the larger one's volume. REQUIRES: the same origin.
  double with(const OverlapTet& other) const;

 private:
  // Sides of it that have a part of the other one behind them.
  struct Cut {
    std::array<HalfSpace, 4> sides;
    std::size_t count = 0;
    bool all = false;  // one has all of it
  };
  Cut cut(const OverlapTet& other) const;

  TetCorners corners_;
  std::array<std::array<DoubleLanes, 2>, 3> lanes_;  // the same, axis by axis
  Vec3<double> least_, most_;
  std::array<HalfSpace, 4> sides_;  // it is what is in all of them
};

}  // namespace tetfusion
