// A mesh that lies in somebody else's memory, read where it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

struct ValuesView {
  ValueType type = ValueType::kFloat64;
  std::span<const std::byte> bytes;

  std::uint64_t size() const { return bytes.size() / size_of(type); }
};

struct ArrayView {
  std::string name;
  std::uint32_t components = 1;
  ValuesView values;
  std::vector<std::string> component_names = {};  // or one a component
  std::string units = {};
};

// Cells are VTK's: types, and offsets into the connectivity, one more than there are cells.
struct MeshView {
  std::string name = "the mesh";  // for messages
  ValuesView points;              // Float32 or Float64
  ValuesView connectivity;        // Int32 or Int64
  ValuesView offsets;             // the same type
  std::span<const std::uint8_t> types;
  bool tets_only = false;                // there are no offsets and types
  std::span<const std::uint8_t> ghosts;  // flags as in vtkGhostType; empty: no ghost cells
  std::vector<ArrayView> point_arrays, cell_arrays;
  bool any_names = false;  // as in files: arrays may be without a name, or share one
  std::map<std::string, std::string> point_markers, cell_markers;  // AttributeSet::active
  std::vector<DataArray> field_data;

  std::uint64_t cells() const { return tets_only ? connectivity.size() / 4 : types.size(); }
};

// A source whose stream() reads the view in windows and keeps nothing of it, but for cells that are
// split or linearized: then points that no cell uses are left out, else all keep their numbers.
// Those of ghost cells stay where they are.
// What the view refers to must outlive the source and its streams. Throws Error(kBadInput) where
// the numbers of values do not fit.
std::unique_ptr<MeshSource> open_view(MeshView view, const OpenOptions& options = {});

}  // namespace tetfusion
