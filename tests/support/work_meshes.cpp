#include "support/work_meshes.h"

#include "mesh/inspection/inspect.h"

namespace tetfusion::testing {

namespace {

template <class Real>
WorkMesh<Real> convert(Geometry geometry) {
  const Inspection inspection = inspect(geometry);
  WorkMesh<Real> mesh;
  mesh.resize_vertices(point_count(geometry.points));
  mesh.resize_tets(geometry.tets.size());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Point p = point(geometry, static_cast<VertexId>(v));
    mesh.positions[v] = {static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)};
    const std::uint8_t flags = inspection.vertex_flags[v];
    mesh.marks[v] =
        static_cast<std::uint8_t>(((flags & kBoundaryVertex) != 0 ? kOnBoundary : 0) |
                                  ((flags & (kBrokenVertex | kCarriedVertex)) != 0 ? kLocked : 0));
  }
  mesh.tets = geometry.tets;
  mesh.point_ids = count_up<VertexId>(mesh.vertex_count());
  mesh.changed.assign(mesh.vertex_count(), 0);
  mesh.remembered.assign(mesh.tets.size(), 0);
  count_incidence(&mesh);
  mark_near_boundary(&mesh);
  return mesh;
}

}  // namespace

WorkMesh<double> to_work_mesh(Geometry geometry) { return convert<double>(std::move(geometry)); }
WorkMesh<float> to_float_work_mesh(Geometry geometry) {
  return convert<float>(std::move(geometry));
}

}  // namespace tetfusion::testing
