// TetGen meshes: NAME.node has the points and NAME.ele the tetrahedra; NAME.face and NAME.edge,
// read where they are, the triangles and lines. Each begins with its counts, # begins a comment:
//
//   points 3 attributes markers          NAME.node
//   number x y z attributes... markers...
//
// The first point's number, 0 or 1, is what all numbers begin with. Attributes of points become the
// arrays "tetgen:attr1", ...; markers of points, faces and edges "tetgen:ref", as do the first
// attributes of tetrahedra, which say their regions; further ones "tetgen:ref2", ... (0 for faces
// and edges). Names are those that meshio uses. Of a list of all faces or edges that the mesh has
// those without a marker, or with 0, are left out.
#pragma once

#include <memory>
#include <string>

#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Given NAME.node or NAME.ele opens all that belong to it. Reads the heads, and the attributes of
// tetrahedra, to see whether they are whole numbers. Throws Error(kBadInput), Error(kIo).
std::unique_ptr<MeshSource> open_tetgen(MappedFile file, const OpenOptions& options = {});

}  // namespace tetfusion
