// TetGen meshes (tetgen_reader.h): NAME.node, NAME.ele, NAME.face and NAME.edge, numbered from 1.
//
// Regions and markers are the cell_labels(), or kTetgenReference with values that are not whole;
// the components of floating-point point arrays become attributes, whose names a comment says.
// Vertices among the cells, and other arrays, have no place.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/formats/mesh_passes.h"

namespace tetfusion {

inline constexpr const char* kTetgenReference = "tetgen:ref";

// The four files, whichever of them `path` names.
std::vector<std::string> tetgen_files(const std::string& path);

// Writes all, and gives each its name when all are whole; .ele is the last one.
void write_tetgen(MeshPasses* mesh, const std::string& path,
                  const std::function<void(double)>& progress);

// Is there room for that point array?
bool has_tetgen_attributes(const ArrayInfo& info);

}  // namespace tetfusion
