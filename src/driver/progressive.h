// A run as a progressive file: its result, and its fusions backwards.
#pragma once

#include <cstdint>

#include "base/run_context.h"
#include "driver/carried_arrays.h"
#include "driver/import.h"
#include "driver/rounds.h"
#include "io/mesh_source.h"
#include "io/output_file.h"

namespace tetfusion {

// About what the logs of a run take in memory for each tetrahedron of the input.
std::uint64_t log_bytes_per_tet(const MeshDescription& mesh);

// Writes the file but for its commit(). `layout` and `mesh` have ImportSettings::keeps_numbers, and
// so has `lower`. The chunks' fusions of a round do not know each other, so they are taken
// backwards in turns, by shares of what each chunk has deleted: wherever one stops, all have been
// undone as far as one another. `some_rewound`: the import may have wound some tetrahedra the other
// way; they are looked for.
template <class Real>
void write_progressive(const MacroLod<Real>& mesh, const WorkMesh<Real>& layout,
                       const LowerPart<Real>& lower, const CarriedArrays& carried,
                       const RoundLogs& logs, bool some_rewound, MeshSource* source,
                       const RunContext& context, OutputFile* file);

}  // namespace tetfusion
