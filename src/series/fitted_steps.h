// The values of arrays of points, fitted to each step; those of arrays that steer until they are
// written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "follow/apply_map.h"
#include "follow/point_weights.h"
#include "io/map_file.h"
#include "io/mesh_source.h"
#include "io/row_file.h"

namespace tetfusion {

// Is there memory for two steps with such arrays at once? By what writing one takes: the values of
// its arrays, and what else is there for each point and cell of the result. `memory` is as in
// PerformanceOptions. Throws Error(kMemory) where there is none for one.
bool have_room_for_two(const MapFile& map, const MeshDescription& step, std::uint64_t memory);

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
