// What of a mesh is not read, or cannot be written: sentences for the user.
#pragma once

#include <string>

#include "io/source/mesh_source.h"

namespace tetfusion {

// A sentence about what of that mesh was not read; empty where all was.
std::string unread_of(const MeshDescription& mesh);

// The same, and what a file of that name cannot hold, as far as no value matters; the last two are
// those of WriteOptions.
std::string left_out_of(const std::string& path, const MeshDescription& mesh,
                        const std::string& label = {}, bool label_comes_first = false);

}  // namespace tetfusion
