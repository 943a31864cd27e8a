// The shapes of the corpus: points and tetrahedra, before they are put anywhere.
#pragma once

#include <string>
#include <vector>

#include "mesh.h"
#include "numbers.h"

namespace corpus {

struct Shape {
  std::vector<Point> points;
  std::vector<Tet> tets;
};

// The Delaunay tetrahedra of points, by insertion into a large tetrahedron whose corners go again;
// points that would make a cell without volume are left out. Never empty.
Shape delaunay(const std::vector<Point>& points);

struct Kind {
  std::string name;
  Shape (*make)(Numbers* numbers);
};

const std::vector<Kind>& kinds();

// Positive orientation, where that is not 0.
void wind(Shape* shape);
// Without the points that no cell uses.
Shape compact(const Shape& shape);

}  // namespace corpus
