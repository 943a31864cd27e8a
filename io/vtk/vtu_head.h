// The head of a .vtu file: which arrays it has and where their values lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/vtk/array_reader.h"
#include "mesh/data_array.h"

namespace pugi {
class xml_node;
}

namespace tetfusion {

struct VtuArray {
  ArrayInfo info;       // tuples: of this piece; 0 when `counted` is false
  bool counted = true;  // false: only the values themselves tell how many there are
  Payload payload;
  bool present = false;  // false for what a piece without points or cells may lack
  std::shared_ptr<const ComputedArray> computed = nullptr;  // instead of a payload
};

struct VtuPiece {
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  std::vector<VtuArray> point_data;  // in the order of VtuHead::point_data, empty without points
  std::vector<VtuArray> cell_data;   // in the order of VtuHead::cell_data, empty without cells
  VtuArray coordinates;
  VtuArray connectivity;
  VtuArray offsets;
  VtuArray types;
  bool has_faces = false;  // of polyhedra
};

struct VtuHead {
  std::string
      format;  // for people: "VTK XML unstructured grid, appended raw, zlib, UInt64 headers"
  BinaryLayout layout;
  std::vector<VtuPiece> pieces;
  std::vector<VtuArray> field_data;
  AttributeSet point_data;  // tuples: all pieces together
  AttributeSet cell_data;
  std::vector<std::string> unread;  // MeshDescription's
};

// Parses the head. All pieces have the same arrays of the same type, and no array claims more
// values than the file has room for. Does not leave the file's pages in memory. Throws
// Error(kBadInput).
VtuHead parse_vtu_head(const MappedFile& file);

// The units that a DataArray or PDataArray element says, without blanks at their ends, as VTK takes
// them; nothing where there are none.
std::string units_of(const pugi::xml_node& array);

}  // namespace tetfusion
