// The volume that two tetrahedra have in common.
#pragma once

#include <array>

#include "mesh/geometry.h"

namespace tetfusion {

using TetCorners = std::array<Vec3<double>, 4>;

// Six times that volume, as the determinant of a tetrahedron is. Both are of positive volume. Exact
// but for rounding of the order of the larger one's.
double overlap(const TetCorners& a, const TetCorners& b);

}  // namespace tetfusion
