#include "driver/scratch_place.h"

#include <filesystem>

namespace tetfusion {

std::string scratch_folder(const SimplifyRequest& request) {
  return request.performance.scratch.empty() ? request.output + ".tetfusion"
                                             : request.performance.scratch;
}

std::string spool_folder(const SimplifyRequest& request) {
  std::error_code ignored;
  const bool is_stream =
      request.output == "-" || std::filesystem::is_other(request.output, ignored);
  return is_stream ? request.performance.scratch : scratch_folder(request);
}

}  // namespace tetfusion
