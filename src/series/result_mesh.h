// The mesh of a shared series, without arrays.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "follow/apply_cells.h"
#include "io/progressive/map_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Of one step, on the result.
struct StepArrays {
  std::vector<DataArray> points, cells, field_data;
};

class ResultMesh {
 public:
  // `path` is a mesh that may have the array of the original's points (options.h); `map` is of the
  // same run and must outlive this.
  ResultMesh(const std::string& path, const MapFile& map);

  // What the cells have in a step, by the map: all but ghost marks.
  std::vector<DataArray> cell_arrays(MeshSource* step, const RunContext& context) const;

  // The mesh with these arrays, and the markers of the step.
  std::unique_ptr<MeshSource> with(StepArrays arrays, const MeshDescription& step) const;

 private:
  const MapFile& map_;
  const CellMover cells_;
  std::vector<DataArray> point_arrays_;  // of the run's own: numbers of the original's points
};

}  // namespace tetfusion
