// How much memory it takes to read a mesh whole.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "io/source/mesh_source.h"

namespace tetfusion {

// How many cells of each VTK type a mesh has.
using CellTypeCounts = std::array<std::uint64_t, 256>;

// Of the values of all arrays.
std::uint64_t bytes_of(const AttributeSet& set);

// Bytes at the worst moment: either when the geometry is being made of what the file has, or when
// all point and cell arrays have been read beside it. Cells that are split count as the most
// tetrahedra that they can become. `ids_of_file`: how many vertices cells have in what is read of
// the file; absent: their corners. Within about 20 % of what was measured.
std::uint64_t memory_to_read(const MeshDescription& description, const CellTypeCounts& cells,
                             std::optional<std::uint64_t> ids_of_file = {});

}  // namespace tetfusion
