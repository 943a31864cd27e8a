// Points with the same coordinates: cracks and faults, or points that someone forgot to merge.
#pragma once

#include <utility>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Each point with the coordinates of an earlier one, and the earliest of those; ascending. -0
// equals 0. The result does not depend on the number of threads.
Vector<std::pair<VertexId, VertexId>> coincident_points(const Points& points);

}  // namespace tetfusion
