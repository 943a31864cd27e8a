// The mesh of a shared series, without arrays, and which cells of the steps its cells are.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "io/map_file.h"
#include "io/mesh_source.h"

namespace tetfusion {

// The array of cells by which they are known: numbers in the steps' files, under a name that the
// mesh has no array of.
ArrayInfo cell_numbers_info(const MeshDescription& mesh);

// Of one step, on the result.
struct StepArrays {
  std::vector<DataArray> points, cells, field_data;
};

class ResultMesh {
 public:
  // `path` is a mesh with the array of cell_numbers_info(), last among its cell arrays, and perhaps
  // that of the original's points (options.h); `map` is of the same run and must outlive this.
  ResultMesh(const std::string& path, const MapFile& map);

  // What the cells have in a step, by their numbers: all but ghost marks.
  std::vector<DataArray> cell_arrays(MeshSource* step, const RunContext& context) const;

  // The mesh with these arrays, and the markers of the step.
  std::unique_ptr<MeshSource> with(StepArrays arrays, const MeshDescription& step) const;

 private:
  const MapFile& map_;
  Vector<std::uint64_t> numbers_;        // of the steps' cells, one a cell of the result
  Vector<std::uint32_t> order_;          // cells of the result, ascending by these
  std::vector<DataArray> point_arrays_;  // of the run's own: numbers of the original's points
};

}  // namespace tetfusion
