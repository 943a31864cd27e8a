// The job: a progressive file in, a level of its mesh out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "base/run_context.h"
#include "io/mesh_sink.h"
#include "io/progressive_file.h"

namespace tetfusion {

struct RefineRequest {
  std::string input, output;
  // The goal, at most one of the two: at most so many tetrahedra, or less by this share of the
  // original's, in [0, 1). None: the original.
  std::optional<std::uint64_t> tets;
  std::optional<double> reduction;
  WriteOptions write;
};

struct RefineReport {
  ProgressiveCounts counts;
  std::uint64_t file_bytes = 0;
  std::uint64_t tets = 0, points = 0;     // of the result
  std::uint64_t undone = 0;               // fusions
  std::map<std::string, double> seconds;  // by phase
  bool reached = true;                    // false: the goal is below what the file begins with
};

// Undoes fusions as long as the goal allows. Of the file no more is read, and held against its
// checksums, than that takes. Throws Error: kUsage for goals that make no sense, kBadInput for a
// file that is damaged, kIo, kInterrupted. On a throw the output has not been touched.
RefineReport refine(const RefineRequest& request, const RunContext& context = {});

}  // namespace tetfusion
