// What became of the surfaces between the regions of a mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "compare/compare.h"
#include "compare/triangles.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

struct InterfaceComparison {
  std::uint64_t original = 0, simplified = 0;  // triangles
  SurfaceDistance distance;                    // in the unit of the coordinates
};

// Interfaces lie where the values of some of these cell arrays, numbers of one component that both
// meshes have, differ. Reads both meshes in windows; their interfaces lie in memory.
InterfaceComparison compare_interfaces(MeshSource* original, MeshSource* simplified,
                                       const std::vector<std::string>& cell_arrays,
                                       const RunContext& context);

// Writes them to the arrays of *comparison, of these meshes, that say several regions.
void add_interfaces(MeshSource* original, MeshSource* simplified, const RunContext& context,
                    Comparison* comparison);

}  // namespace tetfusion
