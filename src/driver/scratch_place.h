// Where a run keeps what does not fit into memory.
#pragma once

#include <string>

#include "driver/request/options.h"

namespace tetfusion {

// The folder for the mesh. None can be made beside standard output: then it is of no use.
std::string scratch_folder(const SimplifyRequest& request);

// The same for a copy of an input that can be read only once (OpenOptions::spool_folder). Empty
// where the output is a stream or a device, and the request names no folder.
std::string spool_folder(const SimplifyRequest& request);

}  // namespace tetfusion
