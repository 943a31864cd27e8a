// How a surface hangs together.
#pragma once

#include <cstdint>

#include "compare/triangles.h"

namespace tetfusion {

struct SurfaceTopology {
  std::uint64_t parts = 0;  // connected by points
  std::int64_t euler = 0;   // points - edges + triangles

  friend bool operator==(const SurfaceTopology&, const SurfaceTopology&) = default;
};

SurfaceTopology topology_of(const TriangleSet& set);

}  // namespace tetfusion
