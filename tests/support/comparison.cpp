#include "support/comparison.h"

#include <fmt/format.h>

#include <iterator>
#include <stdexcept>

#include "io/open_mesh.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

Comparison compare_files(const MeshFile& original, const MeshFile& simplified) {
  const TempDir dir = TempDir::in_memory();
  original.write(dir.file("original.vtu"));
  simplified.write(dir.file("simplified.vtu"));
  const auto first = open_mesh(dir.file("original.vtu"));
  const auto second = open_mesh(dir.file("simplified.vtu"));
  return compare_meshes(first.get(), second.get(), {});
}

const ArrayComparison& array_of(const Comparison& comparison, std::string_view name) {
  for (const ArrayComparison& a : comparison.arrays) {
    if (a.info.name == name) return a;
  }
  throw std::runtime_error(fmt::format("there is no array {}", name));
}

std::string describe(const Comparison& c) {
  std::string text;
  const auto add = [&](const auto&... values) {
    (fmt::format_to(std::back_inserter(text), "{} ", values), ...);
  };
  for (const MeshSize& s : {c.original, c.simplified}) {
    add(s.points, s.tets, s.boundary_triangles, s.volume, s.boundary.parts, s.boundary.euler);
  }
  add(c.diagonal, c.rounding, c.volume_change, c.outside_points, c.outside_max, c.outside_cells,
      c.identical_surface, c.to_simplified.max, c.to_simplified.mean, c.to_original.max,
      c.to_original.mean);
  for (const ArrayComparison& a : c.arrays) {
    add(a.info.name, a.range, a.non_finite, a.undefined, a.rms, a.max, a.max_at.x, a.max_at.y,
        a.max_at.z, a.differing, a.rounding, a.integral_change, a.integral_rounding,
        a.simplified_non_finite, a.cell_rms, a.cell_max, a.gradient_rms, a.l1_change, a.l1_error);
    for (const RegionVolume& r : a.regions) add(r.value, r.original, r.simplified);
  }
  return text;
}

}  // namespace tetfusion::testing
