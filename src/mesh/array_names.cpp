#include "mesh/array_names.h"

namespace tetfusion {

std::string names_of(const AttributeSet& set) {
  std::string names;
  for (const ArrayInfo& a : set.arrays) names += (names.empty() ? "" : ", ") + a.name;
  return names.empty() ? "none" : names;
}

bool is_ghost_mark(const std::string& name) {
  return name == "vtkGhostType" || name == "vtkGhostLevels";
}

}  // namespace tetfusion
