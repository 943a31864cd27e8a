// Which requests are refused before any work.
#pragma once

#include "driver/request/options.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Throws Error(kUsage) for options that contradict each other.
void check_options(const SimplifyRequest& request);

// Throws Error(kUsage) where one of the files that the input consists of would be written over
// while it is needed (a piece takes the mesh with it whose piece it is), or a map one of the other
// files.
void refuse_outputs_among(const MeshDescription& mesh, const SimplifyRequest& request);

}  // namespace tetfusion
