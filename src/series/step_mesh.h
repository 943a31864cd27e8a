// Whether two steps have one mesh: the same points and cells, in the same order.
#pragma once

#include <cstdint>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/original_mesh.h"
#include "io/mesh_stream.h"

namespace tetfusion {

// Checksums of windows of points and of cells: a few bytes for a quarter of a million.
struct MeshPrint {
  std::uint64_t points = 0, cells = 0;
  ValueType point_type = ValueType::kFloat32;
  Vector<std::uint64_t> point_windows, cell_windows;
};

// `used`: takes the points that tetrahedra use; may be null.
MeshPrint print_of(const MeshDescription& mesh, const MeshStream& stream, const RunContext& context,
                   PointSet* used = nullptr);

// Throws Error(kBadInput), saying what differs, where the mesh of `step` is not that of `first`.
// Of `first` is no more read than the window that differs.
void require_same_mesh(const MeshPrint& first_print, MeshSource* first, const MeshPrint& step_print,
                       const MeshDescription& step, const MeshStream& stream);

}  // namespace tetfusion
