#include "support/work_meshes.h"

#include <numeric>

#include "mesh/inspect.h"

namespace tetfusion::testing {

namespace {

template <class Real>
WorkMesh<Real> convert(Geometry geometry) {
  const Inspection inspection = inspect(geometry);
  WorkMesh<Real> mesh;
  std::visit(
      [&](const auto& points) {
        for (const auto& p : points) {
          mesh.positions.push_back(
              {static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)});
        }
      },
      geometry.points);
  mesh.tets = geometry.tets;
  mesh.point_ids.resize(mesh.positions.size());
  std::iota(mesh.point_ids.begin(), mesh.point_ids.end(), VertexId{0});
  mesh.tet_ids.resize(mesh.tets.size());
  std::iota(mesh.tet_ids.begin(), mesh.tet_ids.end(), TetId{0});
  count_incidence(&mesh);
  mesh.changed.assign(mesh.positions.size(), 0);
  mesh.flipped.assign(mesh.tets.size(), 0);
  for (const std::uint8_t flags : inspection.vertex_flags) {
    mesh.marks.push_back(
        static_cast<std::uint8_t>(((flags & kBoundaryVertex) != 0 ? kOnBoundary : 0) |
                                  ((flags & (kBrokenVertex | kCarriedVertex)) != 0 ? kLocked : 0)));
  }
  for (const Tet& t : mesh.tets) {
    int any = 0;
    for (const VertexId v : t) any |= mesh.marks[v];
    if ((any & kOnBoundary) == 0) continue;
    for (const VertexId v : t) mesh.marks[v] |= kNearBoundary;
  }
  return mesh;
}

}  // namespace

WorkMesh<double> to_work_mesh(Geometry geometry) { return convert<double>(std::move(geometry)); }
WorkMesh<float> to_float_work_mesh(Geometry geometry) {
  return convert<float>(std::move(geometry));
}

}  // namespace tetfusion::testing
