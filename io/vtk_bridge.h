// Files that only VTK reads. The core does not link VTK: it loads the module tetfusion-vtk.so when
// such a file is met.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// Reads the whole file with VTK; the grid stays in memory as long as the source lives. The module
// is looked for in the folder that the environment variable TETFUSION_PLUGIN_PATH names, beside the
// executable, and in
// ../lib/tetfusion from there. `what` says what the file is and why it takes VTK, as "a .pvtu with
// ..."; empty: what its first bytes say.
//
// Throws Error(kIo) if the file cannot be opened, and Error(kBadInput) if the module is missing,
// cannot be loaded or is of another version, or if VTK does not make sense of the file;
// Error(kMemory) if VTK takes more memory than it may. To be called from one thread at a time:
// VTK's message window is the process's.
std::unique_ptr<MeshSource> open_with_vtk(const std::string& path, const OpenOptions& options = {},
                                          const std::string& what = "");

// The times of its steps, of a file of a format that may_have_time_steps(). Throws as
// open_with_vtk().
std::vector<double> time_steps_with_vtk(const std::string& path, const OpenOptions& options);

}  // namespace tetfusion
