// Windows of a .vtu file, read without holding more of it than the window.
#pragma once

#include <memory>

#include "io/source/mesh_stream.h"
#include "io/vtk/vtu_input.h"

namespace tetfusion {

// A stream over the one piece of a file: cells and points have the numbers that the file gives
// them, and a cell's row is its number. Nothing when the mesh must be read whole: cells that
// `options` split or linearize, or connectivity in compressed blocks of more than 16 MiB.
//
// Looks once at types, ghost flags, offsets of a mesh of tetrahedra alone, and coordinates, and
// throws what is wrong with them, as read_geometry() does. What it keeps is what its ArrayReaders
// keep, and a bit for each point if a coordinate of any is not finite.
//
// All three outlive the stream.
std::unique_ptr<MeshStream> open_vtu_stream(const VtuInput& input,
                                            const MeshDescription& description,
                                            const OpenOptions& options);

// The same for open_rows(): looks at types and ghost flags alone.
std::unique_ptr<MeshStream> open_vtu_rows(const VtuInput& input, const MeshDescription& description,
                                          const OpenOptions& options);

// The same for one piece of several, which `description` is of; it has cells. It may be without
// tetrahedra: *tets says how many there are.
std::unique_ptr<MeshStream> open_piece_stream(const VtuInput& input, std::size_t piece,
                                              const MeshDescription& description,
                                              const OpenOptions& options, std::uint64_t* tets);

}  // namespace tetfusion
