// Which of the input's arrays ride along.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/mesh_source.h"

namespace tetfusion {

// All but ghost marks, as ghosts were not read, and what only steers.
struct CarriedArrays {
  explicit CarriedArrays(const MeshDescription& mesh);

  std::vector<std::size_t> point_indices;  // in the description, one an array
  std::vector<std::size_t> cell_indices;
  AttributeSet point_data, cell_data;  // those arrays
};

}  // namespace tetfusion
