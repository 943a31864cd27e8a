// What a run would take, said before it begins.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/estimate.h"
#include "driver/request/options.h"
#include "driver/request/report.h"
#include "driver/rounds/memory_plan.h"

namespace tetfusion {

struct RunPlan {
  Method method = Method::kFuse;
  MeshSummary input;  // points and cells as the file counts them; the rest is not known yet
  std::vector<std::string> steering;
  std::vector<std::string> regions;
  std::uint64_t chunks = 1;
  MemoryNeeds needs;
  std::uint64_t memory = 0;  // that the run may use
  bool on_disk = false;      // chunks are kept in `scratch`
  std::string scratch;
  std::uint64_t spooled = 0;  // of an input that can be read only once: a copy of it, also on disk
  int threads = 1;
  bool verifies = false;  // the result will be verified; the estimate does not count that
  RunEstimate estimate;

  // Where the chunks will be.
  std::uint64_t memory_needed() const { return on_disk ? needs.out_of_core : needs.in_core; }
  std::uint64_t scratch_needed() const { return (on_disk ? needs.scratch : 0) + spooled; }
};

// Throws what simplify() would throw before it reads the mesh. Reads the input once, tries
// `sample_tets` tetrahedra of it, and writes nothing.
RunPlan plan_run(const SimplifyRequest& request, const RunContext& context = {},
                 std::uint64_t sample_tets = kSampleTets);

std::string to_json(const RunPlan& plan);

}  // namespace tetfusion
