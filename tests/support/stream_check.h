// Compares what a MeshStream gives in windows with what the MeshSource gives at once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/source/mesh_stream.h"

namespace tetfusion::testing {

// A mesh without numbers: for each tetrahedron, then for each cell of lower dimension, its type,
// the coordinates and arrays of its corners and its own arrays, as bytes. So it does not matter how
// points are numbered, and which of them are unused.
using WrittenMesh = std::vector<std::string>;

// Throws what reading throws.
WrittenMesh write_out_whole(MeshSource* source);
WrittenMesh write_out_windows(const MeshSource& source, const MeshStream& stream,
                              std::uint64_t window);

// Opens the file twice and reads it both ways, in windows of 1, 3, 1000 and all cells (not the
// small ones, where the mesh is large). Both give the same mesh, and count the same copies with
// other values, or, where `same_message`, the same
// error; else either both give an error that names the file, or neither. Reports to GoogleTest.
void expect_windows_like_whole(const std::string& path, const OpenOptions& options,
                               bool same_message = true);

}  // namespace tetfusion::testing
