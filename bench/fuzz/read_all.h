// Reading all that a file offers, as a job might.
#pragma once

#include "fuzz/targets.h"
#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion::fuzz {

OpenOptions options_of(Input input);

// The bytes as a file without a name, called `name` in messages.
MappedFile memory_file(Input input, const char* name);

// The whole mesh and all arrays; then, where windows of the file can be read, these. Throws Error
// for a file that is refused, std::logic_error where whole and windows are not the same mesh, or
// one is refused and the other is not.
void read_all(MeshSource* source);

}  // namespace tetfusion::fuzz
