// What an import found out about its mesh.
#pragma once

#include <cstdint>

#include "mesh/geometry.h"

namespace tetfusion {

struct InputFacts {
  std::uint64_t points = 0;  // used ones
  std::uint64_t tets = 0;
  std::uint64_t boundary_faces = 0;
  double volume = 0;
  std::uint64_t rewound = 0;
  std::uint64_t degenerate = 0;
  std::uint64_t inverted = 0;
  std::uint64_t duplicate_tets = 0;
  std::uint64_t nonconforming_faces = 0;
  std::uint64_t nonmanifold_edges = 0;
  std::uint64_t unused_points = 0;
  std::uint64_t merged_points = 0;
  std::uint64_t differing_points = 0;  // of these: other values were taken
  LargestDifference largest_difference;
  std::uint64_t ghost_cells = 0;
  std::uint64_t valueless_points = 0;   // with a value that steers and is not finite: locked
  std::uint64_t coincident_points = 0;  // locked, where surfaces move
  std::uint64_t carried_triangles = 0;  // of the file, where surfaces move: they hold these
  std::uint64_t locked_vertices = 0;    // for another reason than the boundary
  // Inside, where tetrahedra of different regions meet: of these, unless surfaces move.
  std::uint64_t between_regions = 0;
  std::uint64_t carried_vertices = 0;  // of the locked: those of cells of lower dimension
};

}  // namespace tetfusion
