// Windows of a file of another program's format.
#pragma once

#include <memory>

#include "io/formats/format_source.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Nothing where the mesh must be read whole: cells other than tetrahedra and those of lower
// dimension, no tetrahedra, or arrays whose rows are in no order. Looks once at the coordinates;
// keeps a bit for each point if one of any is not finite. `reader` and `options` must outlive the
// stream.
std::unique_ptr<MeshStream> open_format_stream(const FormatReader& reader,
                                               const OpenOptions& options);

// Throws InvalidMesh: that coordinate (0: x) of a point is not finite.
[[noreturn]] void fail_not_finite(const MeshDescription& mesh, std::uint64_t point,
                                  std::size_t axis, double value);

}  // namespace tetfusion
