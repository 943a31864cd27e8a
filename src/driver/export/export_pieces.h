// A macroLoD to a .pvtu file with several pieces.
#pragma once

#include "driver/export/export_chunks.h"

namespace tetfusion {

// The arrays of points that pieces have: beside those of the mesh one with the points' numbers,
// named GlobalNodeIds or, where that is taken, with a '_' at its end, which is marked as global
// ids. What the input marked so is the same at several points if it was so there, which nobody
// knows before all points are written, and whoever joins pieces by it would join what is apart. It
// is marked as pedigree ids instead, which say where a point comes from, unless another array is.
AttributeSet with_global_ids(AttributeSet point_data);

// Pieces have about the same number of tetrahedra, which follow one another in the order that one
// file would have. Each has its own points, and those between pieces are in all of them, with their
// numbers in that one file as global ids: whoever merges points by them has the very same mesh.
// Cells of lower dimension are a piece of their own, the last.
//
// Memory: as for one file, and for each piece twelve bytes for every point that several of its
// chunks have.
template <class Real>
MeshSummary export_pieces(const ExportJob<Real>& job);

}  // namespace tetfusion
