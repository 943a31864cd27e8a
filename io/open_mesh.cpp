#include "io/open_mesh.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/files/mapped_file.h"
#include "io/foreign_format.h"
#include "io/formats/suffix.h"
#include "io/gmsh/gmsh_head.h"
#include "io/gmsh/gmsh_reader.h"
#include "io/medit/medit_head.h"
#include "io/medit/medit_reader.h"
#include "io/source/chosen_patches.h"
#include "io/tetgen/tetgen_reader.h"
#include "io/vtk/legacy_head.h"
#include "io/vtk/pvtu_reader.h"
#include "io/vtk/vtu_reader.h"
#include "io/vtk/xml_scan.h"
#include "io/vtk_bridge.h"

namespace tetfusion {

namespace {

// Does the name end so, in letters of either size?
bool is_called(const std::string& path, std::initializer_list<std::string_view> suffixes) {
  return std::find(suffixes.begin(), suffixes.end(), suffix_of(path)) != suffixes.end();
}

}  // namespace

std::size_t choose_time_step(const std::string& path, std::size_t steps,
                             std::optional<std::uint64_t> wanted) {
  if (!wanted || *wanted == 0) return 0;
  if (steps == 0) {
    throw Error(ErrorCode::kUsage,
                path + ": there are no time steps in it to choose from: leave --time-step out");
  }
  if (*wanted == kLastTimeStep) return steps - 1;
  if (*wanted < steps) return *wanted;
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{}: there is no time step {} (--time-step): it has {}, {}", path, *wanted, steps,
                  steps == 1 ? "number 0" : fmt::format("from 0 to {}", steps - 1)));
}

std::vector<double> time_steps_of(const std::string& path, const OpenOptions& options) {
  std::error_code unknown;
  if (path == "-" || !std::filesystem::is_regular_file(path, unknown)) return {};
  if (!may_have_time_steps(guess_format_of(path).format)) return {};
  return time_steps_with_vtk(path, options);
}

namespace {

// The content decides. Where it says nothing, a file that is only called .vtu or .mesh goes to the
// native reader: it says best what is wrong with it.
std::unique_ptr<MeshSource> open_whole(const std::string& path, const OpenOptions& options) {
  if (is_openfoam_name(path) && guess_format_of(path).format == ForeignFormat::kOpenFoam) {
    return open_with_vtk(path, options);
  }
  const bool standard_input = path == "-";
  const std::string& folder = options.spool_folder;
  MappedFile file = standard_input
                        ? MappedFile::spool(STDIN_FILENO, path, folder, options.cancelled)
                        : MappedFile::open(path, folder, options.cancelled);
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.size());
  refuse_unread_formats(path, file.bytes(), false);
  const FormatGuess guess = guess_format(path, file.bytes());
  const ForeignFormat foreign = guess.format;
  // A list has steps, but is refused below: each of its files is a mesh.
  if (!may_have_time_steps(foreign) && !guess.is_list) {
    choose_time_step(path, 0, options.time_step);
  }
  const std::string_view type = vtk_file_type(text);
  const bool legacy = is_legacy_grid(text);
  if (type == "UnstructuredGrid" || legacy) {
    std::string cells;
    auto source = legacy ? open_legacy_vtk(std::move(file), options, &cells)
                         : open_vtu(std::move(file), options, &cells);
    if (source) return source;
    const std::string what = (legacy ? "a legacy .vtk with " : "a .vtu with ") + cells;
    if (!standard_input) return open_with_vtk(path, options, what);
    throw Error(ErrorCode::kBadInput,
                "standard input is " + what + ", which VTK reads, and not from there: give a file");
  }
  const auto open_as = [&](auto open) {
    if (options.merge_points) {
      throw Error(ErrorCode::kUsage, path +
                                         ": --merge-points is for VTK's formats and those that "
                                         "VTK reads: convert the mesh to .vtu first");
    }
    return open(std::move(file), options);
  };
  if (looks_like_medit(text)) return open_as(open_medit);
  if (looks_like_gmsh(text)) return open_as(open_gmsh);
  if (type.empty() && is_called(path, {".vtu"})) return open_vtu(std::move(file), options);
  if (is_called(path, {".mesh", ".meshb"})) return open_as(open_medit);
  if (is_called(path, {".msh"})) return open_as(open_gmsh);
  if (!standard_input && is_called(path, {".node", ".ele"})) return open_as(open_tetgen);
  if (standard_input) {
    throw Error(
        ErrorCode::kBadInput,
        "standard input is neither a .vtu file, a legacy .vtk file of an unstructured grid nor a "
        "mesh of Medit or Gmsh, the formats that are read from there");
  }
  std::string what;
  if (type == "PUnstructuredGrid") {
    if (auto source = open_pvtu(file, options, &what)) return source;
  }
  if (foreign == ForeignFormat::kUnknown) refuse_unread_formats(path, file.bytes(), true);
  return open_with_vtk(path, options, what);
}

}  // namespace

bool can_merge_points(const std::string& path) {
  return !is_called(path, {".mesh", ".meshb", ".msh", ".node", ".ele"});
}

std::unique_ptr<MeshSource> open_mesh(const std::string& path, const OpenOptions& options) {
  if (options.drop_patches && !options.dropped_patches.empty()) {
    refuse("--drop-patches leaves out all patches: give that, or --drop-patch for some of them");
  }
  auto mesh = open_whole(path, options);
  if (options.dropped_patches.empty()) return mesh;
  return without_patches(std::move(mesh), options.dropped_patches);
}

}  // namespace tetfusion
