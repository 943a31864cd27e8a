// Arrays of another time step, or of another program, on a mesh that was simplified before.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "follow/apply_cells.h"
#include "follow/point_weights.h"
#include "io/progressive/map_file.h"
#include "io/source/mesh_source.h"
#include "mesh/data_array.h"

namespace tetfusion {

// An array on the simplified mesh, and how far it is off at the original's points that tetrahedra
// use: of floating-point arrays, as shares of the range there (of a constant array: of its largest
// absolute value), over the points where both values are finite.
struct MovedArray {
  DataArray array;
  double rms = 0;
  double max = 0;
  double rounding = 0;  // how much of an error may come from writing values in the array's type
  std::uint64_t max_at = 0;     // the number of that point
  std::uint64_t undefined = 0;  // points where only the simplified mesh's value is not finite
};

// A floating-point array whose values at new points are fitted (fit_values.h), so that none of the
// original's points is off by more than `bound`, if that can be; a share as MovedArray's max.
struct ArrayFit {
  std::string name;
  double bound = std::numeric_limits<double>::infinity();
};

// The point arrays of `source` of those names, all but ghost marks if there are none, as `map` has
// it: a point that stayed keeps its value to the bit; any other one's is interpolated, or, of
// integers, that of the original's point with the largest weight. With `weights`, the map's, arrays
// of floating-point numbers are fitted. In memory are these arrays alone. Without `measured`
// nothing is said of errors. The same for any number of threads. Throws Error(kBadInput) where the
// mesh has not as many points as the map, Error(kUsage) for a name that is none of its arrays; what
// reading throws.
std::vector<MovedArray> apply_map(const MapFile& map, MeshSource* source,
                                  const std::vector<std::string>& names, const RunContext& context,
                                  bool measured = true, const PointWeights* weights = nullptr);

// The same for the arrays of `fits`, fitted within their bounds. Safe to call from several threads
// at once, for several steps.
std::vector<MovedArray> fit_arrays(const MapFile& map, const PointWeights& weights,
                                   MeshSource* source, const std::vector<ArrayFit>& fits,
                                   const RunContext& context, bool measured = true);

// Of the points that stayed.
struct StayedPoints {
  std::uint64_t count = 0;
  std::uint64_t elsewhere =
      0;  // those that have other coordinates in the mesh in hand, by a millionth or more
};
// A mesh that moves, or one with its points in another order, of which a map knows nothing. Throws
// like apply_map().
StayedPoints compare_stayed_points(const MapFile& map, MeshSource* source,
                                   const RunContext& context);

// The simplified mesh with these arrays, the markers of `source`, and its field data. Refers to the
// map and the arrays.
std::unique_ptr<MeshSource> open_moved(const MapFile& map, const std::vector<MovedArray>& arrays,
                                       const std::vector<MovedCells>& cells, MeshSource* source);

}  // namespace tetfusion
