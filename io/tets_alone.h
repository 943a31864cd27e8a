// A mesh without its cells of lower dimension.
#pragma once

#include <memory>

#include "io/mesh_stream.h"

namespace tetfusion {

// A stream over the same mesh whose windows have tetrahedra alone. Rows of cell arrays, and points,
// keep their numbers; cells() and the arrays' lengths still count what is left out.
std::unique_ptr<MeshStream> tets_alone(std::unique_ptr<MeshStream> stream);

}  // namespace tetfusion
