// Writing a whole mesh to a file. The values of each array are asked for when its turn comes, so that one
// array is in memory at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

enum class Encoding { kRaw, kZlib, kLz4, kInline, kAscii };

// What goes into the file. Cells are written tetrahedra first, then the cells of lower dimension; a cell
// array has a tuple for each in that order.
struct OutputMesh {
  const Points* points = nullptr;
  const Vector<Tet>* tets = nullptr;
  const LowerCells* lower = nullptr;  // may be null
  AttributeSet point_data;            // tuples are ignored: they follow from the mesh
  AttributeSet cell_data;
  AttributeSet field_data;            // tuples count here
  std::function<DataArray(Association, std::size_t index)> read_array;
};

struct WriteOptions {
  Encoding encoding = Encoding::kRaw;
  std::function<void(double share)> progress;  // 0..1; may be empty
};

// Throws what write_mesh() would throw for that name, before any work: Error(kUsage) for a format that cannot
// be written, Error(kIo) where no file can be made. Creates nothing.
void check_mesh_output(const std::string& path);

// Writes `path` by way of a temporary file beside it, which is synced and renamed when it is whole: on any
// failure the old file stays. "-" writes to standard output. Throws Error(kIo), or Error(kUsage) for a file
// name whose format cannot be written.
void write_mesh(const OutputMesh& mesh, const std::string& path, const WriteOptions& options = {});

}  // namespace tetfusion
