// Which points of a mesh lie in a region.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/progressive/progressive_file.h"
#include "refine/refinable_mesh.h"

namespace tetfusion {

// 1 for each point of the mesh that does (mesh/regions/region_of_interest.h). Calls keep() now and
// then. Throws Error(kUsage).
Vector<std::uint8_t> points_inside(const RefinableMesh& mesh, const ProgressiveFile& file,
                                   const std::vector<std::string>& region,
                                   const std::function<void()>& keep);

}  // namespace tetfusion
