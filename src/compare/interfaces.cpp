#include "compare/interfaces.h"

#include "compare/original_mesh.h"

namespace tetfusion {

namespace {

constexpr std::size_t kMostInterfaceSides = std::size_t{1} << 21;

TriangleSet interfaces_of(MeshSource* source, const std::vector<std::string>& cell_arrays,
                          const RunContext& context) {
  std::vector<std::size_t> arrays;
  for (const std::string& name : cell_arrays) {
    arrays.push_back(source->description().cell_data.find(name));
  }
  return OriginalMesh(source, {}, {}).find_interfaces(arrays, kMostInterfaceSides, context);
}

}  // namespace

InterfaceComparison compare_interfaces(MeshSource* original, MeshSource* simplified,
                                       const std::vector<std::string>& cell_arrays,
                                       const RunContext& context) {
  const TriangleSet before = interfaces_of(original, cell_arrays, context);
  const TriangleSet after = interfaces_of(simplified, cell_arrays, context);
  return {before.triangles.size(), after.triangles.size(), measure_surfaces(before, after)};
}

void add_interfaces(MeshSource* original, MeshSource* simplified, const RunContext& context,
                    Comparison* comparison) {
  const auto shares = [&](const OneSidedDistance& d) {
    const double unit = comparison->diagonal > 0 ? comparison->diagonal : 1;
    return SurfaceShares{d.max / unit, d.mean / unit, d.max_at};
  };
  for (ArrayComparison& a : comparison->arrays) {
    // What is no number is a region, too.
    const std::size_t others = a.non_finite + a.simplified_non_finite > 0 ? 1 : 0;
    const bool has_several = !a.regions.empty() && a.regions.size() + others > 1;
    if (a.association != Association::kCell || !has_several) continue;
    context.check();
    context.report("interfaces", 1);
    const SurfaceDistance found =
        compare_interfaces(original, simplified, {a.info.name}, context).distance;
    a.interfaces = {found.identical, shares(found.first_to_second), shares(found.second_to_first)};
  }
  std::erase_if(comparison->lost_regions, [&](const std::string& name) {
    return interfaces_of(original, {name}, context).triangles.empty();
  });
}

}  // namespace tetfusion
