#include "cli/findings.h"

#include <fmt/format.h>

#include "base/numbers.h"

namespace tetfusion {

namespace {

std::vector<std::uint64_t> in_file(const FirstIds& ids, const Vector<std::uint64_t>& source) {
  std::vector<std::uint64_t> result;
  for (const std::uint32_t id : ids.ids()) result.push_back(source.empty() ? id : source[id]);
  return result;
}

Json distribution_json(const Distribution& d) {
  return {{"min", d.min}, {"p1", d.p1}, {"mean", d.mean}, {"max", d.max}};
}

}  // namespace

std::vector<Finding> list_findings(const Geometry& geometry, const Inspection& inspection) {
  const auto cells = [&](Defect kind) {
    return in_file(inspection.first(kind), geometry.tet_source);
  };
  const auto points = [&](Defect kind) {
    return in_file(inspection.first(kind), geometry.point_source);
  };
  const Inspection& i = inspection;
  using enum Severity;
  return {
      {"inverted", "inverted cells", kFailure, i.inverted, "cells", cells(Defect::kInverted)},
      {"duplicate_tets", "duplicate cells", kFailure, i.duplicate_tets, "cells",
       cells(Defect::kDuplicate)},
      {"foldover_faces", "fold-over faces", kFailure, i.foldover_faces, "cells",
       cells(Defect::kFoldoverFace)},
      {"overfull_faces", "faces with more than two cells", kFailure, i.overfull_faces, "cells",
       cells(Defect::kOverfullFace)},
      {"degenerate", "degenerate cells", kWarning, i.degenerate, "cells",
       cells(Defect::kDegenerate)},
      {"nonmanifold_edges", "non-manifold boundary edges", kWarning, i.nonmanifold_edges, "points",
       points(Defect::kNonmanifoldEdge)},
      {"nonmanifold_vertices", "non-manifold vertices", kWarning, i.nonmanifold_vertices, "points",
       points(Defect::kNonmanifoldVertex)},
      {"coincident_points", "coincident points", kNote, i.coincident_points, "points",
       points(Defect::kCoincidentPoint)},
      {"unused_points", "unused points", kNote, geometry.unused_points, "points", {}},
      {"merged_points",
       "points merged at seams of pieces",
       kNote,
       geometry.merged_points,
       "points",
       {}},
      {"ghost_cells", "ghost cells left out", kNote, geometry.ghost_cells, "cells", {}},
  };
}

std::string describe_samples(const Finding& finding) {
  if (finding.samples.empty()) return "";
  return fmt::format("{} {}{}", finding.sample_kind, fmt::join(finding.samples, ", "),
                     finding.count > finding.samples.size() ? ", ..." : "");
}

std::string describe_winding(const Geometry& geometry, const Inspection& inspection) {
  if (inspection.rewound == 0) return "";
  if (inspection.rewound + inspection.inverted + inspection.degenerate == geometry.tets.size()) {
    return "All cells are wound the other way than VTK winds them; that is no inversion.";
  }
  return fmt::format(
      "{} of {} cells are wound the other way than VTK winds them; that alone is no inversion.",
      format_count(inspection.rewound), format_count(geometry.tets.size()));
}

Json counts_json(const Geometry& geometry, const Inspection& i) {
  return {{"points", point_count(geometry.points)}, {"tets", geometry.tets.size()},
          {"lower_cells", geometry.lower.size()},   {"components", i.components},
          {"boundary_triangles", i.boundary_faces}, {"boundary_edges", i.boundary_edges},
          {"boundary_points", i.boundary_vertices}, {"surface_components", i.surface_components},
          {"surface_euler", i.surface_euler()},     {"volume", i.volume},
          {"bounding_box", {i.lower, i.upper}},     {"rewound", i.rewound}};
}

Json findings_json(const std::vector<Finding>& findings) {
  Json json;
  Json samples = Json::object();
  for (const Finding& f : findings) {
    json[std::string(f.key)] = f.count;
    if (!f.samples.empty()) samples[std::string(f.key)] = {{std::string(f.sample_kind), f.samples}};
  }
  json["samples"] = samples;
  return json;
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

std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tetfusion
