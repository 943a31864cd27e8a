// A part of a run, as far as progress goes.
#pragma once

#include <string_view>

#include "base/run_context.h"

namespace tetfusion {

// What reports shares from 0 to 1 there reports them as from `from` to `to` of the whole, which
// outlives it. The input's size is not reported again.
inline RunContext part_of_run(const RunContext& whole, double from, double to) {
  RunContext part = whole;
  if (whole.progress) {
    part.progress = [&whole, from, to](std::string_view phase, double share) {
      whole.progress(phase, from + (to - from) * share);
    };
  }
  part.size = {};
  return part;
}

}  // namespace tetfusion
