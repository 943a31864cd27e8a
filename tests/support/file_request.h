// A job from file to file.
#pragma once

#include "driver/request/options.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

// From in.vtu to out.vtu there, all else as it is for a user who says nothing.
inline SimplifyRequest request_in(const TempDir& folder) {
  SimplifyRequest request;
  request.input = folder.file("in.vtu");
  request.output = folder.file("out.vtu");
  return request;
}

}  // namespace tetfusion::testing
