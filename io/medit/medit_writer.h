// Medit meshes (medit_head.h): points, tetrahedra, then triangles, edges and, as RequiredVertices,
// vertices, each with its reference: find_point_labels() or cell_labels(), 0 where there is none.
#pragma once

#include <functional>

#include "io/files/output_file.h"
#include "io/formats/mesh_passes.h"

namespace tetfusion {

// With the lowest version that holds the mesh: 1 for coordinates of 32 bits, 2; in binary 3 and 4
// for files of 2 GiB and more, which have coordinates of 64 bits; 4 for references that need more
// than 32 bits.
void write_medit(MeshPasses* mesh, OutputFile* file, bool binary,
                 const std::function<void(double)>& progress);

}  // namespace tetfusion
