// The job: a progressive file in, a level of its mesh out.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "io/progressive/progressive_file.h"
#include "io/write_mesh.h"

namespace tetfusion {

struct RefineRequest {
  std::string input, output;
  // The goal, at most one of these: at most so many tetrahedra; less by this share of the
  // original's, in [0, 1); the coarsest level whose errors are at most this share of a field's
  // range, at any point of the original or in the mean (FusionErrors). None: the original.
  std::optional<std::uint64_t> tets;
  std::optional<double> reduction, max_error, max_rms;
  // Refine only where these are (mesh/regions/region_of_interest.h), and as far as the goal allows;
  // elsewhere the mesh stays that of the file, but for what has to follow.
  std::vector<std::string> region;
  WriteOptions write;
  // Resident at most; 0: half of what the machine or its control group allows. What does not fit
  // lies on the disk of `scratch`; empty: of the output.
  std::uint64_t memory = 0;
  std::string scratch;
};

struct RefineReport {
  ProgressiveCounts counts;
  std::uint64_t file_bytes = 0;
  std::uint64_t tets = 0, points = 0;  // of the result
  std::uint64_t undone = 0;            // fusions
  FusionErrors errors = FusionErrors::kNone;
  double error = 0;                             // of the result, if that is known
  std::optional<std::uint64_t> inside, needed;  // with a region: points of the original, fusions
  double error_inside = 0;                      // and of these
  std::map<std::string, double> seconds;        // by phase
  bool on_disk = false;
  bool reached = true;  // false: the goal is below what the file begins with
};

// Undoes fusions as long as the goal allows. Of the file no more is read, and held against its
// checksums, than that takes; with a region all of it. Throws Error: kUsage for goals that make no
// sense, or that the file does not know enough for, kBadInput for a file that is damaged, kIo,
// kInterrupted. On a throw the output has not been touched.
RefineReport refine(const RefineRequest& request, const RunContext& context = {});

}  // namespace tetfusion
