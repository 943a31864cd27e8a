// A mesh without some of what lies beside its tetrahedra: patches that are named.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// Leaves out the cells of lower dimension that have one of these: NAME, of a block, by the file's
// names of these (`block_names`, of Exodus with `ElementBlockIds`); or ARRAY=VALUE, of a cell array
// of one number a cell. Points that only these use are used by no cell. Reads what can be read in
// windows once, to count. Throws Error(kUsage) where there is no such block or array, and, here or
// when it is read whole, where no cell of lower dimension is in it.
std::unique_ptr<MeshSource> without_patches(std::unique_ptr<MeshSource> mesh,
                                            const std::vector<std::string>& patches);

}  // namespace tetfusion
