// Arrays of cells that steer a series, as arrays of points.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// The mesh with one more array of points for each array of its cells among `arrays` (as --array
// takes them): "cell:NAME", its means at the points, weighted by volume. They are made when they
// are read first, and kept (8 bytes a component and point). No result has them
// (ArrayInfo::steers_only). The mesh as it is where there are none. `cancelled`, which may be null,
// is RunContext::cancelled.
std::unique_ptr<MeshSource> with_point_means(std::unique_ptr<MeshSource> mesh,
                                             const std::vector<std::string>& arrays,
                                             const std::atomic<bool>* cancelled);

}  // namespace tetfusion
