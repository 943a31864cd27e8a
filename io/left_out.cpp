#include "io/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "io/formats/mesh_passes.h"
#include "io/gmsh/gmsh_head.h"
#include "io/gmsh/gmsh_writer.h"
#include "io/medit/medit_head.h"
#include "io/mesh_format.h"
#include "io/tetgen/tetgen_writer.h"
#include "io/write_mesh.h"
#include "mesh/array_names.h"
#include "mesh/time_value.h"

namespace tetfusion {

namespace {

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
    const std::string& name = mesh.cell_data.arrays[i].name;
    const bool is_twice = mesh.point_data.find(name) != AttributeSet::npos;
    if (i != cell) names.push_back(is_twice ? "cell:" + name : name);
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
