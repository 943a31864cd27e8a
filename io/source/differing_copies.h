// What joining points loses: values that copies have, and the points that stand for them have not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/vector.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct PointCopy {
  VertexId point;
  VertexId original;  // comes before it, and is no copy
};

// Points are counted through all pieces.
struct JoinedPoints {
  std::span<const std::uint64_t> stay;  // a bit a point: some cell uses it, and it is no copy
  std::span<const PointCopy> copies;    // ascending
};

struct CopyDifferences {
  std::uint64_t points = 0;  // copies that have another value in some array
  LargestDifference largest;
};

// The tuples of points first ... first + count - 1 of the array at this index, in native byte order
// and aligned; they stay until the next call. Those of points that no cell uses may be anything.
using ReadPointRows = std::function<std::span<const std::byte>(
    std::size_t array, std::uint64_t first, std::uint64_t count)>;

// Values are the same where they compare equal, and where neither is a number; marks of ghosts are
// not looked at. `largest` is that of a floating-point array where one of these differs.
//
// Asks for rows where there are copies and their originals, once, in ascending windows; again for
// those of more originals than fit into memory, and for all rows of an array in which some differ.
// Takes memory for 4 bytes each original, a byte each copy, a bit each point, and for rows of
// originals the larger one of 4 MiB and two bytes a point.
CopyDifferences find_differences(const JoinedPoints& points, std::span<const ArrayInfo> arrays,
                                 const ReadPointRows& read);

// The same where each point's original is known, itself where it is no copy, as match_points()
// (merge_pieces.h) says.
CopyDifferences find_differences(const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used,
                                 std::span<const ArrayInfo> arrays, const ReadPointRows& read);

// Do copies lie where the points lie that stand for them, but for rounding: a share of 1e-5 of the
// diagonal of all that cells use? If not they were taken for copies by ids that are not global.
// read() gives coordinates, as of an array; `tuples` is how many points there are.
bool lie_together(const JoinedPoints& points, ValueType point_type, std::uint64_t tuples,
                  const ReadPointRows& read);
bool lie_together(const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used,
                  const Points& positions);

}  // namespace tetfusion
