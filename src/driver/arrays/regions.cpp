#include "driver/arrays/regions.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "mesh/regions/region_names.h"

namespace tetfusion {

namespace {

std::string possible_regions(const MeshDescription& mesh) {
  std::string names;
  for (const ArrayInfo& a : mesh.cell_data.arrays) {
    if (can_be_region(a)) names += (names.empty() ? "" : ", ") + a.name;
  }
  return names.empty() ? "none" : names;
}

}  // namespace

std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names,
                                        std::string_view option) {
  std::vector<std::size_t> regions;
  if (!names) {
    for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
      const ArrayInfo& array = mesh.cell_data.arrays[i];
      if (looks_like_region(array)) regions.push_back(i);
    }
    return regions;
  }
  for (const std::string& name : *names) {
    if (name == "none" && names->size() > 1 && mesh.cell_data.find(name) == AttributeSet::npos) {
      throw Error(ErrorCode::kUsage,
                  "--regions none says that no interfaces are kept: give it alone, or not at all");
    }
    const std::size_t i = mesh.cell_data.find(name);
    if (i == AttributeSet::npos || !can_be_region(mesh.cell_data.arrays[i])) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("{}: {} {}: there is no cell array of numbers of one component with that "
                      "name; there are: {}",
                      mesh.path, option, name, possible_regions(mesh)));
    }
    if (std::ranges::find(regions, i) == regions.end()) regions.push_back(i);
  }
  return regions;
}

std::string region_that_was_named(const std::optional<std::vector<std::string>>& names) {
  return names && !names->empty() ? names->front() : std::string();
}

std::vector<std::string> names_of_cell_arrays(const MeshDescription& mesh,
                                              const std::vector<std::size_t>& arrays) {
  std::vector<std::string> names;
  for (const std::size_t i : arrays) names.push_back(mesh.cell_data.arrays[i].name);
  return names;
}

}  // namespace tetfusion
