// Which cell arrays say what the mesh is made of, by their names.
#pragma once

#include "mesh/data_array.h"

namespace tetfusion {

// An integer array of one component.
bool can_be_region(const ArrayInfo& array);

// One of these, named like materials (material, region, physical, tissue, block, zone, part,
// label), or the references of Medit (medit:ref) and TetGen (tetgen:ref); a partition's rank is
// none.
bool looks_like_region(const ArrayInfo& array);

}  // namespace tetfusion
