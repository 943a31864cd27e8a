// Writing a mesh that lies in memory to a file.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "io/write_mesh.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion::testing {

// What goes into the file. Cells are written tetrahedra first, then the cells of lower dimension; a
// cell array has a tuple for each in that order.
struct OutputMesh {
  const Points* points = nullptr;
  const Vector<Tet>* tets = nullptr;
  const LowerCells* lower = nullptr;  // may be null
  AttributeSet point_data;            // tuples are ignored: they follow from the mesh
  AttributeSet cell_data;
  AttributeSet field_data;  // tuples count here
  std::function<DataArray(Association, std::size_t index)> read_array;
};

void write_mesh(const OutputMesh& mesh, const std::string& path, const WriteOptions& options = {});

}  // namespace tetfusion::testing
