#include "driver/scratch_place.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "base/placeholders.h"

namespace tetfusion {

namespace {

// The output, but no more of it than the first folder whose name a step or a level has a part in:
// beside that there is a folder for sure.
std::string in_a_folder(const std::string& output) {
  std::size_t end = output.size();
  for (const std::string_view part : {kStepField, kLodField}) {
    const std::size_t at = output.find(part);
    if (at != std::string::npos) end = std::min(end, output.find('/', at));
  }
  return output.substr(0, end);
}

}  // namespace

std::string scratch_folder(const SimplifyRequest& request) {
  return request.performance.scratch.empty() ? in_a_folder(request.output) + ".tetfusion"
                                             : request.performance.scratch;
}

std::string spool_folder(const SimplifyRequest& request) {
  std::error_code ignored;
  const bool is_stream =
      request.output == "-" || std::filesystem::is_other(request.output, ignored);
  return is_stream ? request.performance.scratch : scratch_folder(request);
}

}  // namespace tetfusion
