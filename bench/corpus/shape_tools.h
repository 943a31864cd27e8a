// What shapes are made of.
#pragma once

#include <array>
#include <functional>

#include "shapes.h"

namespace corpus {

using Cube = std::array<int, 3>;
using KeepCube = std::function<bool(int, int, int)>;

// Cubes cut in five, or in six round their diagonal; `keep` says which cubes there are.
Shape lattice(const Cube& size, bool six, const KeepCube& keep = {});
// Points moved by up to half of a random number below `most`; what that turns over goes back.
Shape jittered(Numbers* n, Shape shape, double most = 0.6);
Cube size_of(Numbers* n, int low, int high);
Shape joined(const Shape& a, const Shape& b);
Shape moved(Shape s, const Point& by, double scale = 1);
// Points of the same coordinates become one where `here` says so.
Shape welded(Shape s, const std::function<bool(const Point&)>& here);
std::size_t nearest(const Shape& s, const Point& place);
Point in_ball(Numbers* n);

// Shapes that others begin with.
Shape single(Numbers*);
Shape five(Numbers* n);
Shape kuhn(Numbers* n);
Shape delaunay_ball(Numbers* n);

// Kinds with broken or overlapping cells.
std::vector<Kind> broken_kinds();

}  // namespace corpus
