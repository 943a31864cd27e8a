#include "io/write_mesh.h"

#include <fmt/format.h>

#include "base/numbers.h"
#include "io/files/output_file.h"
#include "io/gmsh/gmsh_head.h"
#include "io/gmsh/gmsh_writer.h"
#include "io/medit/medit_head.h"
#include "io/medit/medit_writer.h"
#include "io/source/mesh_stream.h"
#include "io/tetgen/tetgen_writer.h"
#include "io/vtk/legacy_writer.h"
#include "mesh/split_cells.h"

namespace tetfusion {

void WriteOptions::report_to(const RunContext& context, double done) {
  progress = [&context, done](double share) {
    context.check();
    context.report("writing", done + (1 - done) * share);
  };
  tell = [&context](std::string_view what) { context.say(what); };
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

std::uint64_t write_mesh(MeshSource* source, const std::string& path, const WriteOptions& options) {
  const MeshFormat format = output_format(path);
  const auto stream = open_stream(source);
  MeshPasses mesh(source, stream.get());
  if (format != MeshFormat::kVtu && format != MeshFormat::kLegacyVtk) {
    const LabelPlace place = label_place(format);
    mesh.choose_labels(possible_labels(source->description().cell_data, place, options.label,
                                       options.label_comes_first),
                       place, options.label, options.label_comes_first, path, options.tell);
  }
  if (format == MeshFormat::kTetgen) {
    const std::size_t vertices = mesh.lower_of_type(kVtkVertex).size();
    if (vertices > 0 && options.tell) {
      options.tell(fmt::format("{} has no place for {}: left out", path,
                               format_count(vertices, "vertex cell")));
    }
    if (options.before_name) options.before_name();
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
  file.commit(options.before_name);
  return mesh.tets();
}

}  // namespace tetfusion
