// Which cell arrays say what the mesh is made of, by their names.
#pragma once

#include "mesh/data_array.h"

namespace tetfusion {

// What Medit and TetGen call references: medit:ref, tetgen:ref.
bool is_reference(const ArrayInfo& array);

// An array of numbers of one component.
bool can_be_region(const ArrayInfo& array);

// One of these, of integers.
bool is_integer_label(const ArrayInfo& array);

// One of those, named like materials (material, region, physical, tissue, block, zone, part,
// label), the references of Medit (medit:ref) and TetGen (tetgen:ref), or the blocks of Exodus
// (ObjectId); a partition's rank and what marks ghosts are none.
bool looks_like_region(const ArrayInfo& array);

// Named like one of those, but of floating-point numbers: labels that a program has written so, or
// a field.
bool is_region_of_floats(const ArrayInfo& array);

// Its name may say which part of a mesh a process had: part, partition, rank, proc.
bool may_be_partition(const ArrayInfo& array);

// Not one of those, but an integer array of one component whose name does not say that it holds
// numbers of cells or ranks: cell_tags, CellEntityIds, marker, but not id, global_ids, RankId.
bool may_be_region(const ArrayInfo& array);

}  // namespace tetfusion
