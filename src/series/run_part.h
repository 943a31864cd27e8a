// A part of a run, as far as progress goes.
#pragma once

#include "base/run_context.h"

namespace tetfusion {

// The input's size is not reported again.
inline RunContext part_of_run(const RunContext& whole, double from, double to) {
  RunContext part = whole.part(from, to);
  part.size = {};
  return part;
}

}  // namespace tetfusion
