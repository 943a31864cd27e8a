// VTK's cells as tetrahedra and cells of lower dimension.
#pragma once

#include <string>

#include "io/source/mesh_source.h"
#include "mesh/geometry.h"
#include "vtk/vtk_pieces.h"

namespace tetfusion {

// One entry for each point of all pieces.
struct PointUse {
  Vector<std::uint8_t> used;  // by a cell that stays
  Vector<VertexId> copy_of;   // match_points(); empty if only one piece brings points
};

// Throws Error(kBadInput), naming the cell, as InvalidMesh where a vertex id is out of range.
PointUse find_point_use(const std::string& path, const PieceList& list, const OpenOptions& options);

// The mesh of all pieces: points that several pieces have are merged, ghost and blanked cells
// dropped, cells split or linearised as the options say, points that no cell uses dropped. `use` is
// what find_point_use() makes of the same list and options. Throws what that throws, InvalidMesh
// for a coordinate that is not finite, Error(kMemory) when there are too many tetrahedra.
Geometry convert_cells(const std::string& path, const PieceList& list, const OpenOptions& options,
                       const PointUse& use);

}  // namespace tetfusion
