// Whether two steps have one mesh: the same points and cells, in the same order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/original_mesh.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Checksums of windows of points and of cells: eight bytes for 65,536.
struct MeshPrint {
  std::uint64_t points = 0, cells = 0;
  ValueType point_type = ValueType::kFloat32;
  Vector<std::uint64_t> point_windows, cell_windows;
};

// `used`: takes the points that tetrahedra use; may be null.
MeshPrint print_of(const MeshDescription& mesh, const MeshStream& stream, const RunContext& context,
                   PointSet* used = nullptr);

using OpenMesh = std::function<std::unique_ptr<MeshSource>()>;

// Throws Error(kBadInput) where the step's numbers of points and cells, and the type of
// coordinates, are not those of `first`, which is opened to say so. Looks at nothing else.
void require_same_size(const MeshPrint& first_print, const OpenMesh& first,
                       const MeshDescription& step, const MeshStream& stream);

// Throws Error(kBadInput), saying what differs, where the mesh of `step` is not that of `first`.
// Of `first` is no more read than the window that differs.
void require_same_mesh(const MeshPrint& first_print, const OpenMesh& first,
                       const MeshPrint& step_print, const MeshDescription& step,
                       const MeshStream& stream);

// The same for all steps but the first, one after the other, in the calling thread alone. A step
// whose file says the mesh in the very bytes of the first one's is not decoded.
using OpenStep = std::function<std::unique_ptr<MeshSource>(std::size_t step)>;
void require_same_meshes(const MeshPrint& first_print, std::size_t steps, const OpenStep& open,
                         const RunContext& context);

}  // namespace tetfusion
