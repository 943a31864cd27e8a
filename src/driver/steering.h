// Which arrays steer, and their values at the vertices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "io/mesh_source.h"
#include "kernel/criteria.h"

namespace tetfusion {

// An array that the user, or the default, chose to steer.
struct SteeringChoice {
  Association association = Association::kPoint;
  std::size_t index = 0;            // in the description's AttributeSet
  std::optional<double> tolerance;  // "NAME:0.5%": its own, as a share of its range
  std::string name;                 // as in the file; "cell:NAME" for a cell array
};

// Resolves the user's names ("NAME", "NAME:0.5%", "cell:NAME"); with none, VTK's active scalars,
// else the first floating-point point array, else nothing. Throws Error(kUsage) naming the arrays
// there are.
std::vector<SteeringChoice> choose_steering(const MeshDescription& mesh,
                                            const std::vector<std::string>& names);

// The values that steer, in the order of the geometry's points, each field in a unit of its own that is a power of two.
struct Steering {
  std::vector<SteeringField> fields;
  std::vector<std::string> names;  // one a field
  std::uint32_t width = 0;         // values a point
  Vector<double> values;
  Vector<std::uint8_t> not_finite;  // one a point: a value is no number, the vertex must stay
};

// Reads the chosen arrays. Cell arrays are averaged at the points, weighted by volume. A field
// whose range is zero is left out, with a notice.
Steering load_steering(const std::vector<SteeringChoice>& choices, const Geometry& geometry,
                       const RunContext& context, MeshSource* source);

}  // namespace tetfusion
