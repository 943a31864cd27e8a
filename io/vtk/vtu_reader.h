// VTK XML unstructured grids (.vtu), read from a mapped file without VTK.
//
// All encodings: appended raw or base64, inline base64, ascii; zlib, LZ4 and LZMA blocks; headers
// of 32 and 64 bits; either byte order; several pieces. Points of different pieces are merged
// (merge_pieces.h), by the global ids if there are any: the point array marked GlobalIds, or called
// GlobalNodeIds, GlobalNodeId or GlobalPointIds.
//
// Ghost cells (vtkGhostType with its bits for copies, refined or hidden cells, or vtkGhostLevels
// above 0) are dropped. As there is only one piece afterwards, read_array returns vtkGhostType
// without these bits and vtkGhostLevels as zeros.
//
// A coordinate that is not finite matters only where a cell uses its point.
//
// Two arrays of one name, and arrays that not all pieces have, are errors.
#pragma once

#include <memory>
#include <string>

#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Reads the head. Throws Error(kBadInput). read_geometry and read_array of the result may be called
// in any order and again; each keeps nothing.
std::unique_ptr<MeshSource> open_vtu(MappedFile file, const OpenOptions& options = {});

// The same, but null for a file with cells that are to be split and that VTK alone reads: `for_vtk`
// then names them, "polyhedra" or "polygons", and is empty otherwise.
std::unique_ptr<MeshSource> open_vtu(MappedFile file, const OpenOptions& options,
                                     std::string* for_vtk);

// The same two for a legacy .vtk file of an unstructured grid (legacy_head.h).
std::unique_ptr<MeshSource> open_legacy_vtk(MappedFile file, const OpenOptions& options = {});
std::unique_ptr<MeshSource> open_legacy_vtk(MappedFile file, const OpenOptions& options,
                                            std::string* for_vtk);

}  // namespace tetfusion
