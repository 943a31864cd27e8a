// A refined mesh as a file.
#pragma once

#include <functional>
#include <string>

#include "io/mesh_sink.h"
#include "io/progressive_file.h"
#include "refine/refinable_mesh.h"

namespace tetfusion {

// Points and cells in the order of their numbers, all arrays, field data. Throws what writing
// throws.
void write_level(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& path,
                 const WriteOptions& options);

}  // namespace tetfusion
