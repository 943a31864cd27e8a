#include "io/mesh_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "base/error.h"
#include "io/output_file.h"

namespace tetfusion {

void check_mesh_output(const std::string& path) {
  std::error_code error;
  const bool special = path == "-" || std::filesystem::is_other(path, error);
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!special && suffix != ".vtu") {
    throw Error(ErrorCode::kUsage,
                fmt::format("cannot write {}: meshes are written as VTK XML unstructured grids; "
                            "give a name that ends in .vtu (simplify also writes .pvtu), or - for "
                            "standard output",
                            path));
  }
  check_output_path(path);
}

}  // namespace tetfusion
