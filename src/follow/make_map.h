// Where each point and each cell of a mesh went when it was simplified, found by looking at both
// meshes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "follow/cell_homes.h"
#include "io/files/output_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// What a run knows of its result. Points and cells are all that it has written, in that order.
struct ResultFacts {
  OriginalNumbers numbers;           // as a stream of the original counts
  std::vector<std::string> regions;  // cell arrays of both meshes: cells of different ones
                                     // have nothing to do with each other
  bool wants_homes = true;           // else cells have none
};

// Writes a map (io/progressive/map_file.h) to `file`, which the caller commits. `result` is where
// the result can be read; `sides` as for compare_meshes().
//
// - A point of the original that stayed lies where it stayed; any other in the tetrahedron that
//   holds it, or, outside of the result, at the nearest point of its boundary.
// - A point of the result that is one of the original's takes its value; any other what the
//   original has at its place, interpolated in the first tetrahedron that holds it, or, outside, at
//   the nearest point of the boundary.
// - A tetrahedron of the original has its home where its centre is. One of the result whose points
//   are those of its origin stays as it is; so does one that cells in its region fill to less than
//   an eighth.
//
// The same bytes for any number of threads. The original is read in windows; in memory are the
// result and the original's boundary triangles. Throws what reading throws, Error(kBadInput) where
// a mesh has no boundary, Error(kIo) and Error(kInterrupted).
void make_map(MeshSource* original, const std::string& result, const ResultFacts& facts,
              std::uint64_t sides, OutputFile* file, const RunContext& context);

// Bytes of memory that takes beside what comparing the two meshes does, for each point and each
// tetrahedron of the result.
inline constexpr std::uint64_t kMapPointBytes = 190, kMapTetBytes = 36;

}  // namespace tetfusion
