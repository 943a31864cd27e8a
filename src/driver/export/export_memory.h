// A macroLoD to a mesh in memory.
#pragma once

#include "driver/export/export_chunks.h"

namespace tetfusion {

// The mesh of export_mesh(), number by number, into the room that settings.sink makes: chunk by
// chunk, side by side.
template <class Real>
MeshSummary export_to_memory(const ExportJob<Real>& job);

}  // namespace tetfusion
