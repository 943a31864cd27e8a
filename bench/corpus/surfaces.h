// The faces of a mesh, and surfaces made of them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "mesh.h"

namespace corpus {

using Face = std::array<std::int64_t, 3>;  // ascending

// Each face with the cells that have it; cells that name a vertex twice have none.
using Faces = std::map<Face, std::vector<std::size_t>>;
Faces faces_of(const std::vector<Tet>& tets);

using Triangles = std::vector<std::array<Point, 3>>;

// By connectivity: parts that hang together by points, Euler number, edges that have another number
// of triangles than two.
struct Topology {
  std::size_t parts = 0, odd_edges = 0;
  long euler = 0;
};
Topology topology_of(const std::vector<Face>& faces);

// The place on a triangle that is nearest to p: the weights of its corners.
struct Nearest {
  double distance;
  std::array<double, 3> weights;
};
Nearest nearest_on(const Point& p, const std::array<Point, 3>& triangle);

// The largest distance of a corner or centre of one surface's triangles from the other surface;
// infinite if that is empty.
double farthest(const Triangles& from, const Triangles& to);

}  // namespace corpus
