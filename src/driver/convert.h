// One format or encoding to another, window by window.
#pragma once

#include <cstdint>
#include <string>

#include "io/mesh_sink.h"
#include "io/mesh_source.h"

namespace tetfusion {

// Writes the mesh of `source` to `path`: tetrahedra first, then the cells of lower dimension, and
// all arrays but ghost marks, as ghosts are not read. In the memory of a few windows and the cells
// of lower dimension, where the source can be read in windows. Returns how many ghosts there were.
std::uint64_t convert_mesh(MeshSource* source, const std::string& path,
                           const WriteOptions& options);

}  // namespace tetfusion
