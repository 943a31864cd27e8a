// The values of arrays of points, fitted to each step; those of arrays that steer until they are
// written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "follow/apply_map.h"
#include "follow/point_weights.h"
#include "io/files/row_file.h"
#include "io/progressive/map_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// What the arrays of a step are, at most: bytes and components.
struct StepWidths {
  std::uint64_t point_bytes = 0, cell_bytes = 0;    // of all arrays, for each point or cell
  std::uint64_t widest_bytes = 0;                   // of one, for each
  std::uint64_t widest_point = 0, widest_cell = 0;  // components; of cells of floating-point ones

  void add(const MeshDescription& step);
};

// Bytes that writing a step with such arrays takes on a result of that size: the values of its
// arrays, and what else is there for each point and cell of the result.
struct StepMemory {
  std::uint64_t once = 0, of_step = 0;
};
StepMemory step_memory(std::uint64_t points, std::uint64_t cells, const StepWidths& step);

// Is there memory for two steps at once? `memory` is as in PerformanceOptions. Throws
// Error(kMemory) where there is none for one.
bool have_room_for_two(const StepMemory& needs, std::uint64_t memory);

// They lie on the disk, and so does what is known of the map's places.
class FittedSteps {
 public:
  // `fits` are of point arrays of `first`; so many steps have arrays of those names, with as many
  // components. `map` must outlive this.
  FittedSteps(const std::string& folder, const MapFile& map, std::vector<ArrayFit> fits,
              const MeshDescription& first, std::size_t steps);

  // Fits the step's arrays; what is returned, one for each of `fits`, says how far they are off,
  // and has no values. Safe to call from several threads at once, for different steps. Throws as
  // fit_arrays(); Error(kIo).
  std::vector<MovedArray> add(std::size_t step, MeshSource* source, const RunContext& context);

  // The same of other arrays of floating-point numbers, without bounds: with their values, which
  // are not kept, and without errors.
  std::vector<MovedArray> fit(const std::vector<std::string>& names, MeshSource* source,
                              const RunContext& context) const;

  // The values of one of those that were added, of a step that was added; `info` is the array in
  // that step.
  DataArray read(std::size_t step, std::size_t array, const ArrayInfo& info) const;

 private:
  std::uint64_t offset(std::size_t step, std::size_t array) const;

  const MapFile& map_;
  const std::vector<ArrayFit> fits_;
  const std::vector<std::uint64_t> sizes_;  // of a step's arrays, at most
  PointWeights weights_;
  RowFile file_;
};

}  // namespace tetfusion
