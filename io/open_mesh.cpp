#include <unistd.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "io/mapped_file.h"
#include "io/mesh_source.h"
#include "io/pvtu_reader.h"
#include "io/vtk_bridge.h"
#include "io/vtu_reader.h"
#include "io/xml_scan.h"

namespace tetfusion {

namespace {

bool is_called_vtu(const std::string& path) {
  constexpr std::string_view kSuffix = ".vtu";
  if (path.size() < kSuffix.size()) return false;
  std::string end = path.substr(path.size() - kSuffix.size());
  std::transform(end.begin(), end.end(), end.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return end == kSuffix;
}

}  // namespace

// The content decides. A file that is only called .vtu goes to the native reader too: it says best
// what is wrong with it.
std::unique_ptr<MeshSource> open_mesh(const std::string& path, const OpenOptions& options) {
  const bool standard_input = path == "-";
  MappedFile file = standard_input ? MappedFile::spool(STDIN_FILENO, path, options.spool_folder)
                                   : MappedFile::open(path, options.spool_folder);
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.size());
  const std::string_view type = vtk_file_type(text);
  if (type == "UnstructuredGrid" || (type.empty() && is_called_vtu(path))) {
    return open_vtu(std::move(file), options);
  }
  if (standard_input) {
    throw Error(ErrorCode::kBadInput,
                "standard input is not a .vtu file, the only format that is read from there");
  }
  if (type == "PUnstructuredGrid") {
    if (auto source = open_pvtu(file, options)) return source;
  }
  return open_with_vtk(path, options);
}

}  // namespace tetfusion
