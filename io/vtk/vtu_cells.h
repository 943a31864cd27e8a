// The cells of a .vtu file, read from connectivity, offsets and types.
#pragma once

#include <cstdint>

#include "base/vector.h"
#include "io/source/file_cells.h"
#include "io/source/mesh_source.h"
#include "io/source/reading_memory.h"
#include "io/vtk/vtu_input.h"

namespace tetfusion {

// Reads and checks all cells, and sets a byte in `used` for each point that a cell which is not a
// ghost uses (the vertices that are left of it with `options`). Throws Error(kBadInput) naming the
// first cell that is not right, InvalidMesh for a vertex id out of range.
FileCells read_cells(const VtuInput& input, const OpenOptions& options, Vector<std::uint8_t>* used);

// Reads no more than the types, and keeps nothing. Throws Error(kBadInput).
CellTypeCounts count_types(const VtuInput& input);
// Vertices of all cells together.
std::uint64_t count_ids(const VtuInput& input);

}  // namespace tetfusion
