// Surfaces of meshes as triangles, and how far they are from one another, the slow way.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "kernel/sheets/patch_distance.h"
#include "mesh/geometry.h"
#include "mesh/work_mesh.h"

namespace tetfusion::testing {

using SurfaceTriangle = std::array<Point3, 3>;

// The boundary, looking out.
std::vector<SurfaceTriangle> surface_of(const WorkMesh<double>& mesh);
// The same as the places of corners, equal for the same triangles in whatever order.
std::multiset<std::set<Point3>> boundary_of(const Geometry& mesh);
// The faces between tetrahedra of different values in the first cell column.
std::vector<SurfaceTriangle> surface_between(const WorkMesh<double>& mesh);

// The larger of the distances from points of one to the other, as far as points on a grid of each
// triangle say.
double distance_between(const std::vector<SurfaceTriangle>& a,
                        const std::vector<SurfaceTriangle>& b);
double distance_to(const Point3& x, const SurfaceTriangle& t);
double furthest(const std::vector<SurfaceTriangle>& from, const std::vector<SurfaceTriangle>& to);

// Pairs of triangles without a common corner that pass through one another.
std::size_t count_crossings(const std::vector<SurfaceTriangle>& surface);

// Where a vertical line first meets one of the triangles.
std::optional<double> height_of(const std::vector<SurfaceTriangle>& surface, double x, double y);

// Vertices less edges plus triangles.
std::int64_t euler_number(const std::set<std::array<VertexId, 3>>& triangles);

}  // namespace tetfusion::testing
