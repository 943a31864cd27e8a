// Signs of determinants of coordinates, without rounding. Coordinates must be such that products of
// five of them neither overflow nor underflow: scale them first.
#pragma once

#include <array>

namespace corpus {

using Point = std::array<double, 3>;

// +1 if d lies on the side of triangle (a, b, c) from which that is seen clockwise, as in VTK's
// winding of tetrahedra; 0 if they lie in one plane.
int orientation(const Point& a, const Point& b, const Point& c, const Point& d);

// For a tetrahedron of positive orientation: +1 if e lies inside its circumsphere, 0 on it.
int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e);

// The largest power of two by which all points can be divided without loss, so that the largest
// coordinate is about 1; small ones that vanish beside it may be rounded.
double unit_of(const Point* points, std::size_t count);

}  // namespace corpus
