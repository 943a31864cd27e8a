// A mesh without the faults that can be mended without guessing (README.md).
#pragma once

#include <cstdint>
#include <memory>

#include "base/run_context.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

struct Repairs {
  std::uint64_t rewound = 0;
  std::uint64_t duplicate_tets = 0;  // dropped
  std::uint64_t unused_points = 0;   // dropped
};

struct RepairedMesh {
  std::unique_ptr<MeshSource> source;
  Repairs repairs;
};

// `original` must outlive the result, whose cells, points and arrays are those of the original in
// their order. Duplicates are looked for where the caller knows that there are some. Reads the
// original in windows; does not depend on the number of threads. Throws what reading throws, and
// Error(kInterrupted).
RepairedMesh repair(MeshSource* original, bool has_duplicates, const RunContext& context);

}  // namespace tetfusion
