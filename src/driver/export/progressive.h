// A run as a progressive file: its result, and its fusions backwards.
#pragma once

#include <cstdint>
#include <string>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/import/import.h"
#include "driver/request/options.h"
#include "driver/rounds/fusion_logs.h"
#include "driver/rounds/memory_plan.h"
#include "driver/rounds/rounds.h"
#include "io/files/output_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// About what a run's logs take for each tetrahedron of the input.
std::uint64_t log_bytes_per_tet(const MeshDescription& mesh);

// Adds what the logs take, and writing the file, in memory and on disk.
void include_logs(const SimplifyRequest& request, const MeshDescription& mesh, int threads,
                  MemoryNeeds* needs);

// They are gone when a mesh has been read. Throws Error(kUsage) where there are any.
void refuse_ghosts(const std::string& input, const InputFacts& facts);

// What the file is made of; all of it outlives the job.
template <class Real>
struct ProgressiveJob {
  const WorkMesh<Real>& layout;  // empty: what a row holds, but for cells' numbers
  const CarriedArrays& carried;
  FusionErrors errors;
  MeshSource* source = nullptr;      // the input
  const MacroLod<Real>& mesh;        // the result, imported with ImportSettings::keeps_numbers,
  const ImportedInput<Real>& input;  // and what that has found out
  FusionLogs* logs = nullptr;        // they are gone afterwards
  const RunContext& context;
  MemoryBudget* budget = nullptr;
  Scratch* scratch = nullptr;
};

// Writes the file but for its commit(). In memory is no more than include_logs() says, wherever the
// mesh and the logs are; the bytes are the same. Reports progress, 0..1, as kWayBackPhase. Throws
// what RunContext::check() throws.
template <class Real>
void write_progressive(const ProgressiveJob<Real>& job, OutputFile* file);

}  // namespace tetfusion
