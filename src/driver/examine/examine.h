// What is to be said of a mesh file, whole in memory or chunk by chunk.
#pragma once

#include <cstdint>
#include <string>

#include "base/run_context.h"
#include "io/source/mesh_source.h"
#include "mesh/inspection/inspection_summary.h"
#include "mesh/quality.h"

namespace tetfusion {

struct ExamineOptions {
  std::uint64_t memory = 0;  // bytes that may be used; 0: half of what the machine allows
  std::string scratch;       // folder for what does not fit into memory; empty: in $TMPDIR or /tmp
  std::uint64_t chunk_tets = 200'000;
  bool in_chunks = false;  // even where the mesh fits into memory
  bool on_disk = false;    // the chunks, even where they fit into memory
};

struct Examination {
  InspectionSummary mesh;
  Quality quality;
};

// Counts and measures are those of inspect() and measure_quality() on the whole mesh (but for the
// last digits of sums), for any number of threads and any memory. In chunks that takes the memory
// of a few chunks, nine bytes a point and what grows with the interfaces between chunks; and 140
// bytes for each cell that uses a point with which something is wrong. Samples of inverted cells
// are missing where a part of the mesh decides which cells are the inverted ones that is larger
// than what lies round them; those of points, where the file has several pieces.
//
// Throws InvalidMesh where the mesh cannot be judged, Error(kMemory) where the memory does not do.
Examination examine(MeshSource* source, const ExamineOptions& options, const RunContext& context);

}  // namespace tetfusion
