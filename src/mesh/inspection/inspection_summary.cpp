#include "mesh/inspection/inspection_summary.h"

namespace tetfusion {

void InspectionSummary::count_lower(const LowerCells& cells) {
  for (const std::uint8_t type : cells.types) {
    ++(type == 1 ? lower_vertices : type == 3 ? lower_lines : lower_triangles);
  }
}

std::array<double, 3> place_of(const Geometry& mesh, Defect kind, std::uint32_t id) {
  return std::visit(
      [&](const auto& points) {
        std::array<double, 3> sum{};
        const auto add = [&](VertexId v, double share) {
          sum[0] += share * points[v].x;
          sum[1] += share * points[v].y;
          sum[2] += share * points[v].z;
        };
        if (is_of_points(kind)) {
          add(id, 1);
        } else {
          for (const VertexId v : mesh.tets[id]) add(v, 0.25);
        }
        return sum;
      },
      mesh.points);
}

InspectionSummary summarize(const Geometry& geometry, const Inspection& inspection) {
  InspectionSummary s;
  static_cast<MeshCounts&>(s) = inspection;
  s.points = point_count(geometry.points);
  s.tets = geometry.tets.size();
  s.count_lower(geometry.lower);
  s.unused_points = geometry.unused_points;
  s.merged_points = geometry.merged_points;
  s.differing_points = geometry.differing_points;
  s.largest_difference = geometry.largest_difference;
  s.ghost_cells = geometry.ghost_cells;
  s.coincident_points = inspection.coincident_points;
  s.components = inspection.components;
  s.surface_components = inspection.surface_components;
  s.volume = inspection.volume;
  s.lower = inspection.lower;
  s.upper = inspection.upper;
  for (std::size_t k = 0; k < kDefectKinds; ++k) {
    const auto kind = static_cast<Defect>(k);
    const auto& source = is_of_points(kind) ? geometry.point_source : geometry.tet_source;
    for (const std::uint32_t id : inspection.samples[k].ids()) {
      s.samples[k].push_back(source.empty() ? id : source[id]);
      s.places[k].push_back(place_of(geometry, kind, id));
    }
  }
  return s;
}

}  // namespace tetfusion
