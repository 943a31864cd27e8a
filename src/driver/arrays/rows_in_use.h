// Which rows of arrays are tetrahedra's: what others have may be anything.
#pragma once

#include <cstdint>
#include <limits>

#include "base/bit_set.h"
#include "base/run_context.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Those of the points that the tetrahedra among the first so many cells use, or of these themselves
// (not of cells of lower dimension, nor of cells that are left out): a bit each.
BitSet find_rows_in_use(const MeshStream& stream, Association association,
                        const RunContext& context,
                        std::uint64_t cells = std::numeric_limits<std::uint64_t>::max());

// Those of all cells but ghosts.
BitSet find_rows_of_cells(const MeshStream& stream, const RunContext& context);

}  // namespace tetfusion
