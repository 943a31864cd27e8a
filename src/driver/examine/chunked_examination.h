// A mesh file looked at in windows and chunks. For examine() alone.
#pragma once

#include <cstdint>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/examine/examine.h"
#include "driver/rounds/memory_plan.h"
#include "io/source/mesh_stream.h"
#include "io/store/scratch.h"

namespace tetfusion {

MemoryNeeds needs_of_examination(const MeshDescription& mesh, const MeshStream& stream,
                                 std::uint64_t chunk_tets, int threads);

Examination examine_chunks(const MeshDescription& mesh, const MeshStream& stream,
                           std::uint64_t chunk_tets, const RunContext& context,
                           MemoryBudget* budget, Scratch* scratch);

}  // namespace tetfusion
