#include "io/mesh_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/numbers.h"
#include "io/gmsh_head.h"
#include "io/gmsh_writer.h"
#include "io/legacy_writer.h"
#include "io/medit_head.h"
#include "io/medit_writer.h"
#include "io/mesh_passes.h"
#include "io/mesh_stream.h"
#include "io/output_file.h"
#include "io/suffix.h"
#include "io/tetgen_writer.h"
#include "mesh/array_names.h"
#include "mesh/split_cells.h"
#include "mesh/time_value.h"

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

LabelPlace label_place(MeshFormat format) {
  switch (format) {
    case MeshFormat::kGmsh:
      return {kGmshPhysical, "physical groups", 32, false, false};
    case MeshFormat::kTetgen:
      return {kTetgenReference, "attributes", 64, true, true};
    default:
      return {kMeditReference, "references", 64, false, true};
  }
}

// As far as names tell.
std::size_t probable_label(const MeshDescription& mesh, const LabelPlace& place,
                           const std::string& label, bool label_comes_first) {
  const auto possible = possible_labels(mesh.cell_data, place, label, label_comes_first);
  return possible.empty() ? AttributeSet::npos : possible.front();
}

// Medit has a place for references alone, TetGen for these and floating-point arrays of points.
std::vector<std::string> arrays_left_out(MeshFormat format, const MeshDescription& mesh,
                                         std::size_t cell) {
  std::vector<std::string> names;
  const std::size_t point = find_point_labels(mesh.point_data, label_place(format).own);
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

std::vector<std::string> arrays_left_out_of_gmsh(const MeshDescription& mesh, std::size_t label) {
  const bool has_data = !mesh.point_data.arrays.empty() || !mesh.cell_data.arrays.empty();
  std::vector<std::string> names;
  const std::size_t own = mesh.cell_data.find(kGmshPhysical);
  if (own != AttributeSet::npos && own != label && !is_float(mesh.cell_data.arrays[own].type)) {
    names.push_back(kGmshPhysical);
  }
  for (const ArrayInfo& array : mesh.field_data.arrays) {
    if (is_gmsh_name(array) || (has_data && is_time_value(array))) continue;
    names.push_back(array.name);
  }
  return names;
}

// Names that do not come back from a Gmsh file.
std::vector<std::string> changed_names(const MeshDescription& mesh) {
  std::vector<std::string> names;
  for (const AttributeSet* set : {&mesh.point_data, &mesh.cell_data}) {
    for (const ArrayInfo& array : set->arrays) {
      if (array.name.empty()) names.push_back("(none)");
      if (array.name.find_first_of("\"\n") != std::string::npos) names.push_back(array.name);
    }
  }
  return names;
}

// Arrays that Gmsh's files hold, and the program does not show.
std::vector<std::string> names_of_odd_width(const MeshDescription& mesh) {
  std::vector<std::string> names;
  for (const AttributeSet* set : {&mesh.point_data, &mesh.cell_data}) {
    for (const ArrayInfo& a : set->arrays) {
      if (a.components != 1 && a.components != 3 && a.components != 9) names.push_back(a.name);
    }
  }
  return names;
}

// What Gmsh's files have doubles for, though they do not hold all of it.
std::vector<std::string> long_integers(const MeshDescription& mesh, std::size_t label) {
  std::vector<std::string> names;
  const auto add = [&](const AttributeSet& set, std::initializer_list<std::size_t> tags) {
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      const ArrayInfo& array = set.arrays[i];
      const bool is_long = array.type == ValueType::kInt64 || array.type == ValueType::kUInt64;
      const bool is_tag = std::find(tags.begin(), tags.end(), i) != tags.end();
      if (is_long && !is_tag) names.push_back(array.name);
    }
  };
  add(mesh.point_data, {});
  add(mesh.cell_data, {label, mesh.cell_data.find(kGmshGeometrical)});
  return names;
}

}  // namespace

void WriteOptions::report_to(const RunContext& context, double done) {
  progress = [&context, done](double share) {
    context.check();
    context.report("writing", done + (1 - done) * share);
  };
  tell = [&context](std::string_view what) { context.say(what); };
}

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
                  fmt::format("{} {}: that is {}; give it a name of its own", option, path, other));
    }
  }
}

void refuse_piece_as_mesh(const std::string& path, const MeshDescription& mesh) {
  if (files_of_mesh(path).size() == 1) refuse_piece(path, mesh);
}

ValueType id_type_for(const MeshLayout& layout, ValueType wanted) {
  const bool fits = layout.corners <= std::numeric_limits<std::int32_t>::max();
  return fits ? wanted : ValueType::kInt64;
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

std::uint64_t write_mesh(MeshSource* source, const std::string& path, const WriteOptions& options) {
  const MeshFormat format = output_format(path);
  const auto stream = open_stream(source);
  MeshPasses mesh(source, stream.get());
  if (format != MeshFormat::kVtu && format != MeshFormat::kLegacyVtk) {
    const LabelPlace place = label_place(format);
    mesh.choose_labels(possible_labels(source->description().cell_data, place, options.label,
                                       options.label_comes_first),
                       place, options.label, path, options.tell);
  }
  if (format == MeshFormat::kTetgen) {
    const std::size_t vertices = mesh.lower_of_type(kVtkVertex).size();
    if (vertices > 0 && options.tell) {
      options.tell(fmt::format("{} has no place for {}: left out", path,
                               format_count(vertices, "vertex cell")));
    }
    write_tetgen(&mesh, path, options.progress);
    return mesh.tets();
  }
  OutputFile file(path);
  const bool binary = options.encoding != Encoding::kAscii;
  if (format == MeshFormat::kLegacyVtk) {
    write_legacy_vtk(&mesh, &file, binary, options.progress);
  } else if (format == MeshFormat::kGmsh) {
    write_gmsh(&mesh, &file, binary, options.progress, options.tell);
  } else {
    write_medit(&mesh, &file, format == MeshFormat::kMeditBinary, options.progress);
  }
  file.commit();
  return mesh.tets();
}

std::string unread_of(const MeshDescription& mesh) {
  std::vector<std::string> sentences;
  if (!mesh.unread.empty()) {
    sentences.push_back(fmt::format("these arrays have strings or bits, and are left out: {}",
                                    fmt::join(mesh.unread, ", ")));
  }
  if (!mesh.left_out.empty()) {
    sentences.push_back(fmt::format("{} has parts that are not read, and left out: {}", mesh.path,
                                    fmt::join(mesh.left_out, ", ")));
  }
  std::vector<std::string> marks;
  for (const ArrayInfo& array : mesh.point_data.arrays) {
    if (is_ghost_mark(array.name)) marks.push_back(array.name);
  }
  for (const ArrayInfo& array : mesh.cell_data.arrays) {
    if (is_ghost_mark(array.name)) marks.push_back("cell:" + array.name);
  }
  if (!marks.empty()) {
    sentences.push_back(fmt::format("marks of what is hidden, or another piece's, are left out: {}",
                                    fmt::join(marks, ", ")));
  }
  return fmt::format("{}", fmt::join(sentences, "; "));
}

std::string left_out_of(const std::string& path, const MeshDescription& mesh,
                        const std::string& label, bool label_comes_first) {
  const MeshFormat format = output_format(path);
  if (format == MeshFormat::kVtu || format == MeshFormat::kLegacyVtk) return unread_of(mesh);
  std::vector<std::string> sentences;
  if (const std::string unread = unread_of(mesh); !unread.empty()) sentences.push_back(unread);
  const bool gmsh = format == MeshFormat::kGmsh;
  const std::size_t cell = probable_label(mesh, label_place(format), label, label_comes_first);
  const std::vector<std::string> names =
      gmsh ? arrays_left_out_of_gmsh(mesh, cell) : arrays_left_out(format, mesh, cell);
  if (!names.empty()) {
    sentences.push_back(fmt::format("{} has no place for these arrays, which are left out: {}",
                                    path, fmt::join(names, ", ")));
  }
  const std::vector<std::string> rounded =
      gmsh ? long_integers(mesh, cell) : std::vector<std::string>{};
  if (!rounded.empty()) {
    sentences.push_back(
        fmt::format("{} has doubles for these integers, which are rounded from 2^53 on: {}", path,
                    fmt::join(rounded, ", ")));
  }
  const std::vector<std::string> odd = gmsh ? names_of_odd_width(mesh) : std::vector<std::string>{};
  if (!odd.empty()) {
    sentences.push_back(fmt::format(
        "Gmsh itself shows arrays of 1, 3 or 9 components; {} has these as they are: {}", path,
        fmt::join(odd, ", ")));
  }
  const std::vector<std::string> changed = gmsh ? changed_names(mesh) : std::vector<std::string>{};
  if (!changed.empty()) {
    sentences.push_back(fmt::format("{} cannot have these names, and gives the arrays others: {}",
                                    path, fmt::join(changed, ", ")));
  }
  return fmt::format("{}", fmt::join(sentences, "; "));
}

}  // namespace tetfusion
