// Gmsh meshes (gmsh_head.h), text or binary, versions 1, 2.0 to 2.2, 4.0 (text alone) and 4.1.
//
// Nodes and elements may have any numbers, in any order. The integer cell arrays "gmsh:physical"
// and "gmsh:geometrical" say to which group and entity an element belongs (0: none; of several
// groups the one that has the fewest elements; versions 1 and 2 list it once for each). $NodeData
// and $ElementData become arrays of doubles; where a file has no value it is NaN. Each name of
// physical groups becomes a field array called "gmsh:physical:NAME", whose rows are tag and
// dimension of each group of that name. Of a partitioned mesh the parts of an entity are put
// together again, and the elements where they meet are left out. Other sections are left out, too,
// and all that is named in the description.
#pragma once

#include <memory>

#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Reads the head; of versions 1 and 2 goes through all elements. Throws Error(kBadInput).
std::unique_ptr<MeshSource> open_gmsh(MappedFile file, const OpenOptions& options = {});

}  // namespace tetfusion
