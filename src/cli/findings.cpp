#include "cli/findings.h"

#include <fmt/format.h>

#include "base/numbers.h"
#include "base/resources.h"
#include "driver/arrays/notices.h"

namespace tetfusion {

namespace {

Json distribution_json(const Distribution& d) {
  return {{"min", d.min}, {"p1", d.p1}, {"mean", d.mean}, {"max", d.max}};
}

}  // namespace

std::vector<Finding> list_findings(const InspectionSummary& mesh, const AttributeSet& point_data) {
  using enum Severity;
  return {
      {"inverted", "inverted cells", kFailure, mesh.inverted, "cells",
       mesh.first(Defect::kInverted), mesh.places_of(Defect::kInverted)},
      {"duplicate_tets", "duplicate cells", kFailure, mesh.duplicate_tets, "cells",
       mesh.first(Defect::kDuplicate), mesh.places_of(Defect::kDuplicate)},
      {"foldover_faces", "fold-over faces", kFailure, mesh.foldover_faces, "cells",
       mesh.first(Defect::kFoldoverFace), mesh.places_of(Defect::kFoldoverFace)},
      {"overfull_faces", "faces with more than two cells", kFailure, mesh.overfull_faces, "cells",
       mesh.first(Defect::kOverfullFace), mesh.places_of(Defect::kOverfullFace)},
      {"degenerate", "degenerate cells", kWarning, mesh.degenerate, "cells",
       mesh.first(Defect::kDegenerate), mesh.places_of(Defect::kDegenerate)},
      {"nonmanifold_edges", "non-manifold boundary edges", kWarning, mesh.nonmanifold_edges,
       "points", mesh.first(Defect::kNonmanifoldEdge), mesh.places_of(Defect::kNonmanifoldEdge)},
      {"nonmanifold_vertices", "non-manifold vertices", kWarning, mesh.nonmanifold_vertices,
       "points", mesh.first(Defect::kNonmanifoldVertex),
       mesh.places_of(Defect::kNonmanifoldVertex)},
      {"coincident_points", "coincident points", kNote, mesh.coincident_points, "points",
       mesh.first(Defect::kCoincidentPoint), mesh.places_of(Defect::kCoincidentPoint)},
      {"unused_points", "unused points", kNote, mesh.unused_points, "points", {}, {}},
      {"merged_points", "points merged with others", kNote, mesh.merged_points, "points", {}, {}},
      {"differing_points",
       "of these with other values in some array",
       kNote,
       mesh.differing_points,
       "points",
       {},
       {},
       describe_difference(mesh.largest_difference, point_data)},
      {"ghost_cells", "ghost cells left out", kNote, mesh.ghost_cells, "cells", {}, {}},
  };
}

std::string describe_samples(const Finding& finding) {
  if (finding.samples.empty()) return finding.remark;
  const std::array<double, 3>& p = finding.places.front();
  return fmt::format("{} {}{}; the first at ({:.9g}, {:.9g}, {:.9g})", finding.sample_kind,
                     fmt::join(finding.samples, ", "),
                     finding.count > finding.samples.size() ? ", ..." : "", p[0], p[1], p[2]);
}

std::string describe_winding(const InspectionSummary& mesh) {
  if (mesh.rewound == 0) return "";
  if (mesh.rewound + mesh.inverted + mesh.degenerate == mesh.tets) {
    return "All cells are wound the other way than VTK winds them; that is no inversion.";
  }
  return fmt::format(
      "wound the other way than VTK winds them: {} of {}; that alone is no inversion.",
      format_count(mesh.rewound), format_count(mesh.tets, "cell"));
}

Json counts_json(const InspectionSummary& m) {
  return {{"points", m.points},
          {"tets", m.tets},
          {"lower_cells", m.lower_cells()},
          {"components", m.components},
          {"boundary_triangles", m.boundary_faces},
          {"boundary_edges", m.boundary_edges},
          {"boundary_points", m.boundary_vertices},
          {"surface_components", m.surface_components},
          {"surface_euler", m.surface_euler()},
          {"volume", m.volume},
          {"bounding_box", {m.lower, m.upper}},
          {"rewound", m.rewound}};
}

Json difference_json(const LargestDifference& largest, const AttributeSet& point_data) {
  if (largest.share == 0 || largest.array >= point_data.arrays.size()) return nullptr;
  return {{"array", point_data.arrays[largest.array].name}, {"share", largest.share}};
}

Json findings_json(const std::vector<Finding>& findings) {
  Json json;
  Json samples = Json::object();
  for (const Finding& f : findings) {
    json[std::string(f.key)] = f.count;
    if (f.samples.empty()) continue;
    samples[std::string(f.key)] = {{std::string(f.sample_kind), f.samples}, {"at", f.places}};
  }
  json["samples"] = samples;
  return json;
}

void add_resources(double start, Json* report) {
  (*report)["seconds"]["total"] = wall_seconds() - start;
  (*report)["cpu_seconds"] = cpu_seconds();
  (*report)["peak_rss_bytes"] = peak_rss_bytes();
  (*report)["threads"] = thread_count();
}

Json quality_json(const Quality& q) {
  return {{"min_dihedral_deg", q.min_dihedral_deg.min},
          {"mean_ratio", distribution_json(q.mean_ratio)},
          {"dihedral_deg", distribution_json(q.min_dihedral_deg)},
          {"mean_ratio_histogram", q.mean_ratio_bins},
          {"dihedral_histogram", q.dihedral_bins},
          {"longest_edge", q.longest_edge},
          {"shortest_edge", q.shortest_edge},
          {"max_aspect", q.max_aspect}};
}

}  // namespace tetfusion
