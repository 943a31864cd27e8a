// The array that says how much errors count: "NAME" of points, "cell:NAME" of cells.
#pragma once

#include <string>

#include "base/run_context.h"
#include "driver/arrays/carried_arrays.h"
#include "io/source/mesh_stream.h"
#include "kernel/fuse/fuse_limits.h"

namespace tetfusion {

// Its column of chunks; none for an empty name. Throws Error(kUsage) where the mesh has no such
// array of one component.
WeightColumn weight_column(const std::string& name, const MeshDescription& mesh,
                           const CarriedArrays& carried);

// So that only the ratios of weights count: costs, which their squares multiply, are told apart no
// finer than by shares of a power of two.
struct WeightScale {
  double scale = 1;  // what weights are multiplied by, which brings the largest to 1
  double mean = 1;   // then, the geometric one
};

// Both are 1 where there are no weights. Those of points that no tetrahedron uses, and of other
// cells than tetrahedra, do not count. Throws Error(kBadInput) where one is negative or not finite.
WeightScale scale_weights(const std::string& name, const MeshDescription& mesh,
                          const MeshStream& stream, const RunContext& context);

}  // namespace tetfusion
