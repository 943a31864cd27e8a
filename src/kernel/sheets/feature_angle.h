// From which angle on an edge of a surface is sharp.
#pragma once

namespace tetfusion {

// Degrees between the normals of two triangles.
inline constexpr double kFeatureAngle = 40;

}  // namespace tetfusion
