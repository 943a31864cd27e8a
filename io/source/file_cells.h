// The cells as a file or somebody's memory has them, on their way to tetrahedra and cells of lower
// dimension.
#pragma once

#include <cstdint>
#include <string>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Pieces one after another, ghost cells marked. Vertex ids count through all pieces. Either
// tetrahedra alone, or cells of all kinds.
struct FileCells {
  Vector<std::uint8_t> types;  // kLeftOut in place of those of cells that are left out
  std::uint64_t ghosts = 0;

  bool tets_only = false;
  Vector<Tet> tets;  // with tets_only: one a cell, ghosts too

  Vector<std::uint64_t> offsets;  // otherwise: one entry more than cells
  Vector<VertexId> connectivity;
};

// Moves the cells into `mesh` under the points' new numbers (empty: as they are), splits what is to
// be split (wedges by their volume, if the mesh has its points), and fills tets, lower, tet_source,
// lower_source and ghost_cells. `path` is for messages. Throws Error(kBadInput) when no tetrahedron
// is left, Error(kMemory) when there are too many.
void take_cells(const std::string& path, FileCells cells, const Vector<VertexId>& new_ids,
                Geometry* mesh);

// Throws Error(kMemory): more than kMaxTets.
[[noreturn]] void fail_too_many_tets(const std::string& path, std::uint64_t tets);

// Sets a point's byte; several threads may mark one point.
void mark_used(std::uint8_t* used, VertexId point);

}  // namespace tetfusion
