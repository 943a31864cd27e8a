// Windows of a mesh that lies in memory.
#pragma once

#include <cstdint>
#include <memory>

#include "io/source/mesh_stream.h"
#include "io/source/mesh_view.h"

namespace tetfusion {

// Looks once at all cells and coordinates, and throws what is wrong with the cells:
// Error(kBadInput), InvalidMesh for an id out of range. Keeps a bit a point where a coordinate of
// any is not finite, and another one where there are ghost cells; where cells are to be split or
// linearized all cells, as tetrahedra, and leaves out points that no cell uses then. All three
// outlive the stream.
std::unique_ptr<MeshStream> open_view_stream(const MeshView& view,
                                             const MeshDescription& description,
                                             const OpenOptions& options);

}  // namespace tetfusion
