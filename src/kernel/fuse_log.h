// What the passes did, as a list, so that arrays which do not steer can follow afterwards, one at a
// time.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

// One TetFuse: four points become one, which goes on under the first one's id. Ids are the input
// geometry's.
struct FuseRecord {
  std::array<VertexId, 4> points;
};

// In order of time. No record of a pass reads a point that another record of the same pass has
// written.
struct FuseLog {
  Vector<FuseRecord> records;
  Vector<std::uint8_t> nearest;   // which of a record's four points was nearest to the fused one
  Vector<std::size_t> pass_ends;  // records.size() at the end of each pass

  std::size_t size() const { return records.size(); }
};

// Gives each fused point the value that the old cavity's piecewise-linear interpolant has at the
// barycenter of the prey: the mean of its four values; integers take the nearest point's. `array`
// has a tuple a row; the row of point p is rows[p], or p where `rows` is empty. The first tuples of
// fused points are overwritten.
void carry_point_array(const FuseLog& log, std::span<const std::uint64_t> rows, DataArray* array);

}  // namespace tetfusion
