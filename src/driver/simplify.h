// The main job: a mesh file in, a simplified mesh file out.
#pragma once

#include "base/run_context.h"
#include "driver/memory_plan.h"
#include "driver/options.h"
#include "driver/report.h"

namespace tetfusion {

// Reads request.input, runs greedy passes of TetFuse until the goal is reached or nothing fuses,
// and writes request.output (and a file a level, with request.behaviour.lods). Each file appears
// under its name when it is whole. The files' bytes are a function of the input and the behaviour
// options alone.
//
// Throws Error: kUsage for options that contradict each other or the mesh, kBadInput, kIo,
// kInterrupted. On a throw no output has been touched, but for levels that were already whole.
SimplifyReport simplify(const SimplifyRequest& request, const RunContext& context = {});

// What simplify() would need, estimated from the head of the input.
struct RunPlan {
  MeshSummary input;  // points and cells as the file counts them; the rest is not known yet
  std::vector<std::string> steering;
  std::vector<std::string> regions;
  std::uint64_t chunks = 1;
  MemoryNeeds needs;
  std::uint64_t memory = 0;  // that the run may use
  bool on_disk = false;      // chunks are kept in `scratch`
  std::string scratch;
};

// Throws what simplify() would throw before it reads the mesh. Writes nothing.
RunPlan plan_run(const SimplifyRequest& request);

}  // namespace tetfusion
