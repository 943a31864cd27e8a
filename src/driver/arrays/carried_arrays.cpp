#include "driver/arrays/carried_arrays.h"

#include <algorithm>

#include "mesh/array_names.h"

namespace tetfusion {

namespace {

AttributeSet those_carried(const AttributeSet& set, std::vector<std::size_t>* indices) {
  AttributeSet kept;
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    if (is_ghost_mark(set.arrays[i].name) || set.arrays[i].steers_only) continue;
    kept.arrays.push_back(set.arrays[i]);
    indices->push_back(i);
  }
  kept.active = set.active;
  std::erase_if(kept.active, [](const auto& marker) { return is_ghost_mark(marker.second); });
  return kept;
}

}  // namespace

CarriedArrays::CarriedArrays(const MeshDescription& mesh)
    : point_data(those_carried(mesh.point_data, &point_indices)),
      cell_data(those_carried(mesh.cell_data, &cell_indices)) {}

std::optional<std::uint32_t> CarriedArrays::column_of(Association association,
                                                      std::size_t index) const {
  const auto& indices = association == Association::kCell ? cell_indices : point_indices;
  const auto at = std::ranges::find(indices, index);
  if (at == indices.end()) return std::nullopt;
  return static_cast<std::uint32_t>(at - indices.begin());
}

}  // namespace tetfusion
