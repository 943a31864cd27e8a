// How this program writes cells: tetrahedra first, then those of lower dimension.
#pragma once

#include <cstdint>

#include "io/vtk/vtu_writer.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct CellOrder {
  std::uint64_t tets = 0;
  // May be null. The connectivity is not looked at: somebody else may have renumbered it.
  const LowerCells* lower = nullptr;

  std::uint64_t size() const { return tets + (lower != nullptr ? lower->size() : 0); }
  // Of one cell, what "offsets" and "types" say.
  std::int64_t end(std::uint64_t cell) const;
  std::uint8_t type(std::uint64_t cell) const;
};

// Writes the last two arrays of a file, for all cells.
void put_ends_and_types(const CellOrder& cells, VtuWriter* writer);

}  // namespace tetfusion
