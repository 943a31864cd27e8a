// VTK's cells as tetrahedra and cells of lower dimension.
#pragma once

#include <string>

#include "io/mesh_source.h"
#include "mesh/geometry.h"
#include "vtk/vtk_pieces.h"

namespace tetfusion {

// The mesh of all pieces: points that several pieces have are merged, ghost and blanked cells
// dropped, cells split or linearised as the options say, points that no cell uses dropped. Throws
// Error(kBadInput), naming the cell or the point, as InvalidMesh where a vertex id is out of range
// or a coordinate not finite; Error(kMemory) when there are too many tetrahedra.
Geometry convert_cells(const std::string& path, const PieceList& list, const OpenOptions& options);

}  // namespace tetfusion
