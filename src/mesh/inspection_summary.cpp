#include "mesh/inspection_summary.h"

namespace tetfusion {

void InspectionSummary::count_lower(const LowerCells& cells) {
  for (const std::uint8_t type : cells.types) {
    ++(type == 1 ? lower_vertices : type == 3 ? lower_lines : lower_triangles);
  }
}

InspectionSummary summarize(const Geometry& geometry, const Inspection& inspection) {
  InspectionSummary s;
  static_cast<MeshCounts&>(s) = inspection;
  s.points = point_count(geometry.points);
  s.tets = geometry.tets.size();
  s.count_lower(geometry.lower);
  s.unused_points = geometry.unused_points;
  s.merged_points = geometry.merged_points;
  s.ghost_cells = geometry.ghost_cells;
  s.coincident_points = inspection.coincident_points;
  s.components = inspection.components;
  s.surface_components = inspection.surface_components;
  s.volume = inspection.volume;
  s.lower = inspection.lower;
  s.upper = inspection.upper;
  for (std::size_t kind = 0; kind < kDefectKinds; ++kind) {
    const bool of_points = kind >= static_cast<std::size_t>(Defect::kNonmanifoldEdge);
    const auto& source = of_points ? geometry.point_source : geometry.tet_source;
    for (const std::uint32_t id : inspection.samples[kind].ids()) {
      s.samples[kind].push_back(source.empty() ? id : source[id]);
    }
  }
  return s;
}

}  // namespace tetfusion
