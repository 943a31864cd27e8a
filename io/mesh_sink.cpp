#include "io/mesh_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "io/gmsh_writer.h"
#include "io/legacy_writer.h"
#include "io/medit_head.h"
#include "io/medit_writer.h"
#include "io/mesh_passes.h"
#include "io/mesh_stream.h"
#include "io/output_file.h"
#include "io/tetgen_writer.h"

namespace tetfusion {

namespace {

struct Suffix {
  std::string_view end;
  MeshFormat format;
};

constexpr std::array<Suffix, 7> kSuffixes = {{{".vtu", MeshFormat::kVtu},
                                              {".vtk", MeshFormat::kLegacyVtk},
                                              {".mesh", MeshFormat::kMedit},
                                              {".meshb", MeshFormat::kMeditBinary},
                                              {".msh", MeshFormat::kGmsh},
                                              {".node", MeshFormat::kTetgen},
                                              {".ele", MeshFormat::kTetgen}}};

bool has_encoding(MeshFormat format, Encoding encoding) {
  switch (format) {
    case MeshFormat::kVtu:
      return true;
    case MeshFormat::kLegacyVtk:
    case MeshFormat::kMedit:
    case MeshFormat::kGmsh:
    case MeshFormat::kTetgen:
      return encoding == Encoding::kRaw || encoding == Encoding::kAscii;
    case MeshFormat::kMeditBinary:
      return encoding == Encoding::kRaw;
  }
  return false;
}

// Medit has a place for references alone, TetGen for these and floating-point arrays of points.
std::vector<std::string> arrays_left_out(MeshFormat format, const MeshDescription& mesh) {
  std::vector<std::string> names;
  const char* const own = format == MeshFormat::kTetgen ? kTetgenReference : kMeditReference;
  const std::size_t point = find_references(mesh.point_data, Association::kPoint, own);
  const std::size_t cell = find_references(mesh.cell_data, Association::kCell, own);
  for (std::size_t i = 0; i < mesh.point_data.arrays.size(); ++i) {
    const ArrayInfo& info = mesh.point_data.arrays[i];
    if (i == point || (format == MeshFormat::kTetgen && has_tetgen_attributes(info))) continue;
    names.push_back(info.name);
  }
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    if (i != cell) names.push_back(mesh.cell_data.arrays[i].name);
  }
  for (const ArrayInfo& array : mesh.field_data.arrays) names.push_back(array.name);
  return names;
}

std::vector<std::string> arrays_left_out_of_gmsh(const MeshDescription& mesh) {
  std::vector<std::string> names;
  for (const ArrayInfo& array : mesh.field_data.arrays) {
    if (!is_gmsh_name(array)) names.push_back(array.name);
  }
  return names;
}

}  // namespace

MeshFormat output_format(const std::string& path) {
  std::error_code error;
  if (path == "-" || std::filesystem::is_other(path, error)) return MeshFormat::kVtu;
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Suffix& known : kSuffixes) {
    if (suffix == known.end) return known.format;
  }
  throw Error(
      ErrorCode::kUsage,
      fmt::format("cannot write {}: the end of its name says no format that is written; "
                  "there are .vtu and .vtk (VTK; simplify also writes .pvtu), .mesh and "
                  ".meshb (Medit), .msh (Gmsh), .node and .ele (TetGen), and - for a .vtu to "
                  "standard output",
                  path));
}

void check_mesh_output(const std::string& path, Encoding encoding) {
  if (!has_encoding(output_format(path), encoding)) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("cannot write {} in this --encoding: of .vtk and .msh files there is ascii "
                    "besides, the others belong to .vtu files",
                    path));
  }
  if (output_format(path) != MeshFormat::kTetgen) return check_output_path(path);
  for (const std::string& name : tetgen_files(path)) check_output_path(name);
}

void write_mesh(MeshSource* source, const std::string& path, const WriteOptions& options) {
  const MeshFormat format = output_format(path);
  const auto stream = open_stream(source);
  MeshPasses mesh(source, stream.get());
  if (format == MeshFormat::kTetgen) return write_tetgen(&mesh, path, options.progress);
  OutputFile file(path);
  const bool binary = options.encoding != Encoding::kAscii;
  if (format == MeshFormat::kLegacyVtk) {
    write_legacy_vtk(&mesh, &file, binary, options.progress);
  } else if (format == MeshFormat::kGmsh) {
    write_gmsh(&mesh, &file, binary, options.progress);
  } else {
    write_medit(&mesh, &file, format == MeshFormat::kMeditBinary, options.progress);
  }
  file.commit();
}

std::string left_out_of(const std::string& path, const MeshDescription& mesh) {
  const MeshFormat format = output_format(path);
  if (format == MeshFormat::kVtu || format == MeshFormat::kLegacyVtk) return {};
  const std::vector<std::string> names =
      format == MeshFormat::kGmsh ? arrays_left_out_of_gmsh(mesh) : arrays_left_out(format, mesh);
  if (names.empty()) return {};
  return fmt::format("{} has no place for these arrays, which are left out: {}", path,
                     fmt::join(names, ", "));
}

}  // namespace tetfusion
