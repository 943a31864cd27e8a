// The main job: a mesh file in, a simplified mesh file out.
#pragma once

#include "base/run_context.h"
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

}  // namespace tetfusion
