// Writing a mesh that another program made, window after window.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "base/run_context.h"
#include "io/formats/mesh_passes.h"
#include "io/mesh_format.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

struct WriteOptions {
  Encoding encoding = Encoding::kRaw;
  std::function<void(double share)> progress;  // 0..1; may be empty
  // A cell array of whole numbers, of any type, that says what cells are: where a format has
  // references or groups and the mesh none of another format, they are this one's. It need not be
  // there.
  std::string label = {};
  bool label_comes_first = false;  // before those that the mesh has of any format
  // Told, as sentences, of cells that the format has no place for, and of arrays whose values do
  // not let them be what the format has for them; may be empty.
  std::function<void(std::string_view)> tell = {};
  // Called when the file is whole, before it has its name (of several files: before they are
  // written); may throw: the old file stays then. May be empty.
  std::function<void()> before_name = {};

  // Sets progress and tell(): writing is what is left of a run when that share is done. The context
  // outlives what is written.
  void report_to(const RunContext& context, double done = 0);
};

// Where a format that is not one of VTK's has labels of cells.
LabelPlace label_place(MeshFormat format);

// Writes the mesh to a file that is no .vtu: tetrahedra first, then the cells of lower dimension,
// in the memory of a few windows and these cells, where the source can be read in windows. Returns
// how many tetrahedra there are.
std::uint64_t write_mesh(MeshSource* source, const std::string& path, const WriteOptions& options);

}  // namespace tetfusion
