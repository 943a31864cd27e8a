// Which of the input's arrays ride along.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// All but ghost marks, as ghosts were not read, and what only steers.
struct CarriedArrays {
  explicit CarriedArrays(const MeshDescription& mesh);

  // The column of an array that is carried, by its place in the description.
  std::optional<std::uint32_t> column_of(Association association, std::size_t index) const;

  std::vector<std::size_t> point_indices;  // in the description, one an array
  std::vector<std::size_t> cell_indices;
  AttributeSet point_data, cell_data;  // those arrays
};

}  // namespace tetfusion
