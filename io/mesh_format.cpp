#include "io/mesh_format.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "base/error.h"
#include "base/placeholders.h"
#include "io/files/output_file.h"
#include "io/formats/suffix.h"
#include "io/tetgen/tetgen_writer.h"

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

}  // namespace

MeshFormat output_format(const std::string& path) {
  std::error_code error;
  if (path == "-" || std::filesystem::is_other(path, error)) return MeshFormat::kVtu;
  const std::string suffix = suffix_of(path);
  for (const Suffix& known : kSuffixes) {
    if (suffix == known.end) return known.format;
  }
  throw Error(
      ErrorCode::kUsage,
      fmt::format(
          "cannot write {}: the end of its name says no format that is written; "
          "there are .vtu and .vtk (VTK; simplify also writes .pvtu, and .pvd for a series), "
          ".mesh and .meshb (Medit), .msh (Gmsh), .node and .ele (TetGen), and - for a .vtu "
          "to standard output",
          path));
}

std::vector<std::string> files_of_mesh(const std::string& path) {
  const std::string suffix = suffix_of(path);
  if (suffix == ".node" || suffix == ".ele") return tetgen_files(path);
  return {path};
}

void refuse_piece(const std::string& path, const MeshDescription& mesh) {
  for (const std::string& file : mesh.files) {
    std::error_code not_there;
    if (path.empty() || !std::filesystem::equivalent(path, file, not_there)) continue;
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: that is one of the files of {}; give another name", path, mesh.path));
  }
}

void refuse_same_file(std::string_view option, const std::string& path,
                      const std::vector<std::string>& others) {
  if (path.empty() || path == "-") return;
  const auto plain = [](const std::string& p) {
    return std::filesystem::absolute(p).lexically_normal();
  };
  for (const std::string& name : others) {
    if (name.empty() || name == "-") continue;
    for (const std::string& other : files_of_mesh(name)) {
      std::error_code not_there;
      if (!std::filesystem::equivalent(path, other, not_there) && plain(path) != plain(other)) {
        continue;
      }
      throw Error(ErrorCode::kUsage,
                  fmt::format("{} {}: {} is read or written, too; give it a name of its own",
                              option, path, other));
    }
  }
}

void refuse_piece_as_mesh(const std::string& path, const MeshDescription& mesh) {
  if (files_of_mesh(path).size() == 1) refuse_piece(path, mesh);
}

void check_mesh_output(const std::string& path, Encoding encoding) {
  const std::string file = std::filesystem::path(path).filename().string();
  for (const std::string_view field : {kStepField, kLodField}) {
    if (file.find(field) == std::string::npos) continue;
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{} holds {}, which stands for one of several meshes, but one is written "
                    "here",
                    path, field));
  }
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

}  // namespace tetfusion
