// Which of the original's cells a result still has to have, and how large cells are.
#pragma once

#include <cstdint>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/point.h"
#include "io/source/mesh_source.h"
#include "mesh/regions/region_of_interest.h"

namespace tetfusion {

// What tells tetrahedra apart by the places of their corners, in any order; ascending.
Vector<std::uint64_t> cell_keys(const Geometry& mesh);

struct OriginalCellFacts {
  std::uint64_t inside = 0;   // cells all of whose points are in the region
  std::uint64_t missing = 0;  // those of them that are not among the keys
  Point first_missing{};      // its centre
  double largest_volume = 0;  // of any cell
};

// Reads the original in windows. Of `region`, which may be empty, a bit a point is in memory.
OriginalCellFacts survey_cells(MeshSource* original, const RegionOfInterest& region,
                               const Vector<std::uint64_t>& keys, const RunContext& context);

// 0 if there is none.
double largest_volume(const Geometry& mesh);

}  // namespace tetfusion
