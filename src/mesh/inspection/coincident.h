// Points with the same coordinates: cracks and faults, or points that someone forgot to merge.
#pragma once

#include <cstdint>
#include <utility>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

inline constexpr std::uint32_t kCoordinateShards = 256;

// In [0, kCoordinateShards): the same for points with the same coordinates, and about equally many
// points for each.
template <class Real>
std::uint32_t coordinate_shard(const Vec3<Real>& p);

// Each point with the coordinates of an earlier one, and the earliest of those; ascending. -0
// equals 0. The result does not depend on the number of threads.
Vector<std::pair<VertexId, VertexId>> coincident_points(const Points& points);

}  // namespace tetfusion
