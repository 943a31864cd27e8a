// Makers of small meshes. All cells have positive volume unless a name says otherwise.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "mesh/geometry.h"

namespace tetfusion::testing {

using Point = Vec3<double>;

// Float64 points and tetrahedra as given.
Geometry make_mesh(std::initializer_list<Point> points, std::initializer_list<Tet> tets);
// The same mesh with Float32 points.
Geometry to_float(const Geometry& mesh);

// The corner of the unit cube: volume 1/6.
Geometry single_tet();
// Two tetrahedra that share one triangle, one edge, or one vertex.
Geometry two_tets_sharing_face();
Geometry two_tets_sharing_edge();
Geometry two_tets_sharing_vertex();
// The 20 tetrahedra between an icosahedron and its centre, which is vertex 0 and the only interior
// one.
Geometry icosahedron_ball();

// The box of nx * ny * nz unit cubes, each split in five, mirrored in every second one so that the
// faces fit. Vertices run fastest in x. Interior vertices move by up to `jitter` (0 to 0.2 keeps
// every cell positive), the same for the same seed.
Geometry five_split_box(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double jitter = 0,
                        std::uint64_t seed = 1);
Geometry five_split_cube(std::uint32_t n, double jitter = 0, std::uint64_t seed = 1);
// The corner of such a cube that is half as wide, n even, with all points of the cube.
Geometry corner_of_a_cube(std::uint32_t n);
// The same box with each cube split in six round its diagonal (Kuhn).
Geometry kuhn_box(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double jitter = 0,
                  std::uint64_t seed = 1);
// A plate one layer thick: every vertex is on the boundary.
Geometry plate(std::uint32_t n);

// A number in [0, 1) that depends on the arguments alone.
double uniform(std::uint64_t seed, std::uint64_t index);

// Swaps two corners: winds the cell the other way.
void flip_winding(Tet* tet);

Point point(const Geometry& mesh, VertexId v);

}  // namespace tetfusion::testing
