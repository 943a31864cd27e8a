// Windows of a mesh in several pieces, of one .vtu file or of several, read without holding more of
// them than the window.
#pragma once

#include <memory>
#include <vector>

#include "io/source/mesh_stream.h"
#include "io/vtk/vtu_input.h"

namespace tetfusion {

// A piece of a file; pieces have the same arrays in the same order, but for empty ones.
struct StreamPiece {
  const VtuInput* input = nullptr;
  std::size_t piece = 0;
};

// A stream over all of them. Points are numbered as reading the mesh whole would (merge_pieces.h):
// unused points are dropped, copies merged, the others keep their order. Cells are counted through
// the pieces; a cell's row is its number. Nothing where a piece cannot be streamed.
//
// Goes once through the cells, and once or a few times through the points, to find the copies.
// Keeps about a bit a point, and eight bytes for each copy. Throws what read_geometry() throws. All
// of the arguments outlive the stream. What copies had other values of is found out when it is
// asked for (differing_copies.h).
std::unique_ptr<MeshStream> open_pieces_stream(const std::vector<StreamPiece>& pieces,
                                               const MeshDescription& description,
                                               const OpenOptions& options);

}  // namespace tetfusion
