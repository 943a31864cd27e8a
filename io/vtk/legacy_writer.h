// Legacy .vtk files of unstructured grids (legacy_head.h), version 5.1: all arrays, in their order,
// the active ones as what they are, names of components, field data.
#pragma once

#include <functional>

#include "io/files/output_file.h"
#include "io/formats/mesh_passes.h"

namespace tetfusion {

void write_legacy_vtk(MeshPasses* mesh, OutputFile* file, bool binary,
                      const std::function<void(double)>& progress);

}  // namespace tetfusion
