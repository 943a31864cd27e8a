#include "driver/carried_arrays.h"

#include <string>

namespace tetfusion {

bool is_ghost_mark(const std::string& name) {
  return name == "vtkGhostType" || name == "vtkGhostLevels";
}

namespace {

AttributeSet without_ghost_marks(const AttributeSet& set, std::vector<std::size_t>* indices) {
  AttributeSet kept;
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    if (is_ghost_mark(set.arrays[i].name)) continue;
    kept.arrays.push_back(set.arrays[i]);
    indices->push_back(i);
  }
  kept.active = set.active;
  std::erase_if(kept.active, [](const auto& marker) { return is_ghost_mark(marker.second); });
  return kept;
}

}  // namespace

CarriedArrays::CarriedArrays(const MeshDescription& mesh)
    : point_data(without_ghost_marks(mesh.point_data, &point_indices)),
      cell_data(without_ghost_marks(mesh.cell_data, &cell_indices)) {}

}  // namespace tetfusion
