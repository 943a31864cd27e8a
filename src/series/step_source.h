// A step's mesh with the step's own arrays.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "io/mesh_source.h"
#include "series/series_plan.h"

namespace tetfusion {

// What stands for that array where steps are arrays of one mesh, if it is one of this step.
std::optional<std::string> pattern_of(const Step& step, const std::string& name);

// Where steps are arrays of one mesh, other steps' arrays are left out (but not `weight`), and the
// step's own ones have the names that hold {step}. Else it is the file itself.
std::unique_ptr<MeshSource> open_step(std::unique_ptr<MeshSource> file, const SeriesPlan& plan,
                                      const Step& step, const std::string& weight);

}  // namespace tetfusion
