// Gmsh meshes (gmsh_head.h) of version 2.2, which holds a physical group and an entity for each
// element on its own, and which Gmsh and other programs read alike.
//
// Physical groups are the cell_labels(), 0 where there are none; entities the array
// "gmsh:geometrical", where none of them is of several groups, else the group, or, for values below
// 1, which are no groups, numbers behind. All other arrays become $NodeData and $ElementData, as
// doubles, without rows of which nothing is a number; names of groups come from the field arrays
// that reading a Gmsh file makes.
#pragma once

#include <functional>
#include <string_view>

#include "io/files/output_file.h"
#include "io/formats/mesh_passes.h"

namespace tetfusion {

// What a user should know, a sentence at a time; may be empty.
using TellUser = std::function<void(std::string_view)>;

// Throws Error(kUsage) for more points or cells than the format can number.
void write_gmsh(MeshPasses* mesh, OutputFile* file, bool binary,
                const std::function<void(double)>& progress, const TellUser& tell);

// The field array is a name of physical groups.
bool is_gmsh_name(const ArrayInfo& field);

}  // namespace tetfusion
