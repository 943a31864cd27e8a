// A macroLoD to a .pvtu file with several pieces.
#pragma once

#include "driver/export_chunks.h"

namespace tetfusion {

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
