// A run as a progressive file: its result, and its fusions backwards.
#pragma once

#include <cstdint>
#include <string>

#include "base/run_context.h"
#include "driver/carried_arrays.h"
#include "driver/error_limits.h"
#include "driver/import.h"
#include "driver/memory_plan.h"
#include "driver/options.h"
#include "driver/rounds.h"
#include "io/mesh_source.h"
#include "io/output_file.h"

namespace tetfusion {

// Adds what the logs of a run take in memory. Throws Error(kMemory) where it may not have `total`
// bytes, Error(kUsage) where the mesh is to lie on disk.
void include_logs(const SimplifyRequest& request, const MeshDescription& mesh, std::uint64_t total,
                  MemoryNeeds* needs);

// They are gone when a mesh has been read. Throws Error(kUsage) where there are any.
void refuse_ghosts(const std::string& input, const InputFacts& facts);

// Writes the file but for its commit(). `mesh` was imported with ImportSettings::keeps_numbers; its
// cells of lower dimension lose their numbers here. The chunks' fusions of a round do not know each
// other, so they are taken backwards in turns, by shares of what each chunk has deleted: wherever
// one stops, all have been undone as far as one another.
template <class Real>
void write_progressive(const WorkMesh<Real>& layout, const CarriedArrays& carried,
                       const RoundLogs& logs, const NotedErrors& errors, MeshSource* source,
                       const RunContext& context, ImportedMesh<Real>* mesh, OutputFile* file);

}  // namespace tetfusion
