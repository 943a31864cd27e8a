// Arrays of cells of another time step, or of another program, on a mesh that was simplified
// before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/run_context.h"
#include "base/vector.h"
#include "io/progressive/map_file.h"
#include "io/source/mesh_source.h"
#include "mesh/data_array.h"

namespace tetfusion {

// An array on the simplified mesh.
struct MovedCells {
  DataArray array;
  bool has_means = false;  // else each cell has the values of one of the original's
};

// Are its tetrahedra those of the mesh that was simplified, in their order?
bool has_cells_of(const MapFile& map, MeshSource* source, const RunContext& context);

// Safe to use from several threads.
class CellMover {
 public:
  explicit CellMover(const MapFile& map);  // which outlives it

  // The cell arrays of `source` at these indices, as the map has it (MapOrigin). Values that are
  // not finite do not count, unless most of the volume is theirs. A tetrahedron that is one of the
  // original's keeps its values to the bit. In memory are these arrays, and eight bytes for each
  // tetrahedron, and each component there, of the one in hand. The same for any number of threads.
  // `source` has the cells of the mesh that was simplified; throws what reading throws, and
  // std::out_of_range where it has fewer.
  std::vector<MovedCells> move(MeshSource* source, const std::vector<std::size_t>& arrays,
                               const RunContext& context) const;

 private:
  MovedCells move_one(const MeshStream& stream, const ArrayInfo& info, std::size_t index,
                      const RunContext& context) const;

  const MapFile& map_;
  Vector<std::uint32_t> order_;  // cells of the result, ascending by their origins
};

// All but ghost marks.
std::vector<std::size_t> cell_arrays_to_move(const AttributeSet& cell_data);

}  // namespace tetfusion
