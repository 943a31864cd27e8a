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

struct Overlap {
  // Six times the common volume, as the determinant of a tetrahedron is. Exact but for rounding of
  // the order of the larger one's volume.
  double volume = 0;
  // Of the other one's faces, each by the corner opposite to it, those that may have something of
  // the first one on their far side, as bits: all where there is no common volume.
  unsigned crossed = 15;
};

// A tetrahedron of positive volume, ready to be held against many others.
class OverlapTet {
 public:
  explicit OverlapTet(const TetCorners& corners);

  // The other one has a positive volume, too.
  Overlap with(const TetCorners& other) const;

  // Do the boxes round them have something in common?
  bool is_near(const TetCorners& other) const;

 private:
  // Four points, axis by axis.
  using Lanes4 = std::array<std::array<DoubleLanes, 2>, 3>;
  using Sides = std::array<HalfSpace, 4>;
  // Sides that have a part of the other one behind them.
  struct Cut {
    Sides sides;
    std::size_t count = 0;
    unsigned which = 0;  // these, as bits
    bool all = false;    // one has all of it
  };
  static Lanes4 lanes_of(const TetCorners& corners);
  static Sides sides_of(const TetCorners& corners);
  static Cut cut(const Lanes4& points, const Sides& by);

  Vec3<double> origin_;  // about that nothing is rounded to units of places far away
  Vec3<double> least_, most_;
  TetCorners corners_;  // from here on about the origin
  Lanes4 lanes_;
  Sides sides_;  // it is what is in all of them
};

}  // namespace tetfusion
