// One format or encoding to another, window by window.
#pragma once

#include <string>

#include "driver/request/input_facts.h"
#include "io/source/mesh_source.h"
#include "io/write_mesh.h"

namespace tetfusion {

// Writes the mesh of `source` to `path`: tetrahedra first, then the cells of lower dimension, and
// all arrays but ghost marks, as ghosts are not read. In the memory of a few windows and the cells
// of lower dimension, where the source can be read in windows. Of the facts only how many
// tetrahedra there are, and those on pieces, are returned: ghosts, and points at seams.
InputFacts convert_mesh(MeshSource* source, const std::string& path, const WriteOptions& options);

}  // namespace tetfusion
