// Writing a macroLoD with all the arrays that its input had.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "driver/options.h"
#include "io/mesh_sink.h"
#include "io/mesh_source.h"
#include "kernel/fuse_log.h"
#include "mesh/geometry.h"

namespace tetfusion {

// A macroLoD and where its parts came from.
struct Result {
  Geometry mesh;               // its lower cells name its own points; the *_source arrays are empty
  Vector<VertexId> point_ids;  // ids in the input geometry
  Vector<TetId> tet_ids;
};

// Where the rows of the input's arrays are: the *_source arrays of the geometry that was read.
struct InputRows {
  std::span<const std::uint64_t> points;
  std::span<const std::uint64_t> tets;
  std::span<const std::uint64_t> lower;
};

// Writes the result with every point and cell array of the source under its own name and type:
// fused points have the values that the log gives them, surviving tetrahedra and carried cells keep
// theirs. Only the ghost marks (vtkGhostType) are left out, as ghosts were not read. One array is
// in memory at a time.
void write_result(const Result& result, const FuseLog& log, const InputRows& rows,
                  const std::string& path, const WriteOptions& options, MeshSource* source);

}  // namespace tetfusion
