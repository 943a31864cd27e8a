// Files that only VTK reads. The core does not link VTK: it loads the module tetfusion-vtk.so when
// such a file is met.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/mesh_source.h"

namespace tetfusion {

enum class ForeignFormat { kUnknown, kLegacyVtk, kXmlVtk, kNetCdf, kHdf5 };

struct FormatGuess {
  ForeignFormat format = ForeignFormat::kUnknown;
  std::string words = "a file of unknown format";  // "a legacy VTK file", ...
  bool is_list = false;                            // of other files: a .pvd
};

// What the first bytes of a file (a few hundred are enough) say that it is.
FormatGuess guess_format(std::span<const std::byte> head);

// Reads the whole file with VTK; the grid stays in memory as long as the source lives. The module
// is looked for in the folder that the environment variable TETFUSION_PLUGIN_PATH names, beside the
// executable, and in
// ../lib/tetfusion from there. `what` says what the file is and why it takes VTK, as "a .pvtu with
// ..."; empty: what its first bytes say.
//
// Throws Error(kIo) if the file cannot be opened, and Error(kBadInput) if the module is missing,
// cannot be loaded or is of another version, or if VTK does not make sense of the file. To be
// called from one thread at a time: VTK's message window is the process's.
std::unique_ptr<MeshSource> open_with_vtk(const std::string& path, const OpenOptions& options = {},
                                          const std::string& what = "");

// The times of its steps, of a file that kNetCdf or kHdf5 stands for. Throws as open_with_vtk().
std::vector<double> time_steps_with_vtk(const std::string& path);

}  // namespace tetfusion
