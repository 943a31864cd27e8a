// Memory that a mesh is put into.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/source/mesh_source.h"
#include "mesh/data_array.h"

namespace tetfusion {

// A mesh that goes to memory. Cells are VTK's, as MeshView has them: tetrahedra first.
struct MeshLayout {
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t cells = 0;    // those of lower dimension, too
  std::uint64_t corners = 0;  // of all cells
  ValueType point_type = ValueType::kFloat32;
  AttributeSet point_data, cell_data;  // tuples are ignored
};

// What numbers of points and offsets are to be, kInt32 or kInt64, where those of the input were
// `wanted`: kInt64 where that has no room for the number of corners, as when cells were split.
ValueType id_type_for(const MeshLayout& layout, ValueType wanted);

// Memory for a mesh of that layout, which somebody else owns.
struct MeshRoom {
  std::byte* points = nullptr;            // three coordinates each
  ValueType id_type = ValueType::kInt64;  // of the next two: kInt32, if they fit, or kInt64
  std::byte* connectivity = nullptr;
  std::byte* offsets = nullptr;   // one more than cells; may be null where all are tetrahedra
  std::uint8_t* types = nullptr;  // may be null where offsets are
  std::vector<std::byte*> point_arrays, cell_arrays;
};

class MeshSink {
 public:
  virtual ~MeshSink() = default;
  // Called once, before anything is put there.
  virtual MeshRoom make_room(const MeshLayout& layout) = 0;
};

}  // namespace tetfusion
