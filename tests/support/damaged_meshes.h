// Meshes with something wrong, for the judges of meshes.
#pragma once

#include <cstdint>

#include "mesh/geometry.h"

namespace tetfusion::testing {

// A small grid of one or several components into which defects of every kind were thrown: holes,
// cells wound the other way, duplicates, overfull faces, cells without volume or that name a vertex
// twice, vertices pushed through their neighbours, cells glued together at a vertex or an edge. The
// same for the same seed.
Geometry damaged_mesh(std::uint64_t seed);

// Renumbers the points and shuffles the cells.
void shuffle(Geometry* mesh, std::uint64_t seed);

}  // namespace tetfusion::testing
