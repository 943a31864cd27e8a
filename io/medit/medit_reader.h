// Medit meshes (medit_head.h), text or binary.
//
// References become the integer array "medit:ref" of points and of cells (0 for points that have
// none). RequiredVertices are vertices among the cells. What else there may be (corners, ridges,
// normals) is left out, and named in the description.
#pragma once

#include <memory>

#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Reads the head. Throws Error(kBadInput).
std::unique_ptr<MeshSource> open_medit(MappedFile file, const OpenOptions& options = {});

}  // namespace tetfusion
