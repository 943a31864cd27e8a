// A mesh with other arrays than its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Where an array's values come from: rows from `first` on fill `out`. Called from several threads.
// `mesh` is the stream of the mesh that is dressed.
using FillRows =
    std::function<void(const MeshStream& mesh, std::uint64_t first, std::span<std::byte> out)>;

struct ArrayFrom {
  ArrayInfo info;
  FillRows fill;
};

// An array of the mesh that is dressed.
ArrayFrom own_array(const MeshDescription& mesh, Association association, std::size_t index);

struct OtherArrays {
  std::string path;  // in place of the mesh's own
  std::vector<ArrayFrom> points, cells;
  std::map<std::string, std::string> point_markers, cell_markers;  // AttributeSet::active
  std::vector<DataArray> field_data;
};

// Takes the mesh; numbers and windows are its own, so its rows are what `fill` is asked for.
std::unique_ptr<MeshSource> with_arrays(std::unique_ptr<MeshSource> mesh, OtherArrays arrays);

}  // namespace tetfusion
