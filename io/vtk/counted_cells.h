// Cells as files up to version 4.2 of VTK's legacy format list them: how many points, then these,
// cell after cell.
#pragma once

#include <cstdint>
#include <memory>

#include "io/vtk/array_reader.h"
#include "io/vtk/computed_array.h"

namespace tetfusion {

// What the list holds, as the later versions have it.
struct CountedCells {
  std::shared_ptr<const ComputedArray> offsets;       // Int64: where each cell ends
  std::shared_ptr<const ComputedArray> connectivity;  // of the list's type
};

// Goes through the list, of Int32 or Int64, once, and keeps 16 bytes for each 16,384 cells. Throws
// Error(kBadInput) where it holds more or less than so many cells.
CountedCells count_cells(ArrayReader list, std::uint64_t cells);

}  // namespace tetfusion
