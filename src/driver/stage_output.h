// The end of a stage: values are fitted, files are written, looked at, and get their names.
#pragma once

#include <optional>

#include "driver/coarsening.h"
#include "driver/request/report.h"
#include "driver/request/stages.h"
#include "driver/run.h"
#include "verify/verify.h"

namespace tetfusion {

struct StageOutput {
  MeshSummary mesh;  // as it was written
  std::optional<Verification> verified;
};

// Writes the mesh as it is, with the values of new points fitted where the run puts them aside, to
// the stage's file or the run's sink; and the stage's map, and the way back, where they are wanted.
// None of these has its name before all are whole and the result is what was promised. With
// `is_last` no round follows. Throws Error: kBroken for a promise that is not kept; kIo, kMemory,
// kInterrupted. Files that were there before stay then.
template <class Real>
StageOutput write_stage(const Stage& stage, bool is_last, Run* run, Coarsening<Real>* coarsening);

}  // namespace tetfusion
