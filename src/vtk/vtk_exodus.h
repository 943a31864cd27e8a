// Exodus II files, where VTK has their reader: time steps, element blocks, sets.
#pragma once

#include <string>
#include <vector>

#include "io/mesh_source.h"
#include "vtk/vtk_load.h"
#include "vtk/vtk_trap.h"

namespace tetfusion {

// Throw Error(kBadInput) with VTK's own words if its reader complains, or if this build's VTK has
// none; load_exodus() Error(kUsage) for a time step that is not there.
std::vector<double> find_time_steps(const std::string& path);
void load_exodus(const std::string& path, const OpenOptions& options, const TrapScope& trap,
                 LoadedFile* out);

}  // namespace tetfusion
