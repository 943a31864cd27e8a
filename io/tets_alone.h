// A mesh without its cells of lower dimension.
#pragma once

#include <memory>

#include "io/mesh_source.h"

namespace tetfusion {

// The same mesh with tetrahedra alone, read whole or in windows. Rows of cell arrays keep their
// numbers, and so do points in windows of the file; the description, and cells() of a stream of the
// file, still count what is left out.
std::unique_ptr<MeshSource> tets_alone(std::unique_ptr<MeshSource> source);

}  // namespace tetfusion
