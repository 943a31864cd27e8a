// What a run's result depends on, as text: an interrupted run goes on only with the same.
#pragma once

#include <string>

#include "driver/request/options.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// One "name: value" a line: the program's version, the behaviour options, the output's name and
// encoding, and the input's size, time of change and a hash of samples all over it; of an input
// that was spooled its size and checksum.
std::string fingerprint(const SimplifyRequest& request, const MeshDescription& mesh);

}  // namespace tetfusion
