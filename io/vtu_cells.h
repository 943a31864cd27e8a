// The cells of a .vtu file: from connectivity, offsets and types to tetrahedra and cells of lower
// dimension.
#pragma once

#include <cstdint>
#include <string>

#include "base/vector.h"
#include "io/mesh_source.h"
#include "io/reading_memory.h"
#include "io/vtu_cell_arrays.h"
#include "io/vtu_input.h"
#include "mesh/geometry.h"

namespace tetfusion {

// The cells as the file has them, pieces one after another, ghost cells marked. Vertex ids count
// through all pieces. Either tetrahedra alone, or cells of all kinds.
struct VtuCells {
  Vector<std::uint8_t> types;  // kLeftOut in place of those of cells that are left out
  std::uint64_t ghosts = 0;

  bool tets_only = false;
  Vector<Tet> tets;  // with tets_only: one a cell, ghosts too

  Vector<std::uint64_t> offsets;  // otherwise: one entry more than cells
  Vector<VertexId> connectivity;
};

// Reads and checks all cells, and sets a byte in `used` for each point that a cell which is not a
// ghost uses (the vertices that are left of it with `options`). Throws Error(kBadInput) naming the
// first cell that is not right, InvalidMesh for a vertex id out of range.
VtuCells read_cells(const VtuInput& input, const OpenOptions& options, Vector<std::uint8_t>* used);

// Reads no more than the types, and keeps nothing. Throws Error(kBadInput).
CellTypeCounts count_types(const VtuInput& input);
// Vertices of all cells together.
std::uint64_t count_ids(const VtuInput& input);

// Moves the cells into `mesh` under the points' new numbers (empty: as they are), splits what is to
// be split, and fills tets, lower, tet_source, lower_source and ghost_cells. `path` is for
// messages. Throws Error(kBadInput) when no tetrahedron is left, Error(kMemory) when there are too
// many.
void take_cells(const std::string& path, VtuCells cells, const Vector<VertexId>& new_ids,
                Geometry* mesh);

// Throws Error(kMemory): more than kMaxTets.
[[noreturn]] void fail_too_many_tets(const std::string& path, std::uint64_t tets);

}  // namespace tetfusion
