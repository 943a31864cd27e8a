#include "driver/regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "base/error.h"

namespace tetfusion {

namespace {

bool can_be_region(const ArrayInfo& array) {
  return array.components == 1 && !is_float(array.type) && array.type != ValueType::kString;
}

bool is_named_like_material(std::string_view name) {
  constexpr std::array<std::string_view, 8> kWords{"material", "region", "physical", "tissue",
                                                   "block",    "zone",   "part",     "label"};
  // A partition's rank says who computed a cell, not what it is made of.
  constexpr std::array<std::string_view, 3> kPartitions{"partition", "particle", "parallel"};
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto contains = [&](std::string_view word) {
    return lower.find(word) != std::string::npos;
  };
  return std::any_of(kWords.begin(), kWords.end(), contains) &&
         std::none_of(kPartitions.begin(), kPartitions.end(), contains);
}

}  // namespace

std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names) {
  std::vector<std::size_t> regions;
  if (!names) {
    for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
      const ArrayInfo& array = mesh.cell_data.arrays[i];
      if (can_be_region(array) && is_named_like_material(array.name)) regions.push_back(i);
    }
    return regions;
  }
  for (const std::string& name : *names) {
    const std::size_t i = mesh.cell_data.find(name);
    if (i == AttributeSet::npos || !can_be_region(mesh.cell_data.arrays[i])) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("{}: --regions {}: there is no integer cell array of one component with that "
                      "name; see 'tetfusion info {}'",
                      mesh.path, name, mesh.path));
    }
    regions.push_back(i);
  }
  return regions;
}

}  // namespace tetfusion
