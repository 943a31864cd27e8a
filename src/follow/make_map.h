// Where each point of a mesh went when it was simplified, found by looking at both meshes.
#pragma once

#include <cstdint>
#include <string>

#include "base/run_context.h"
#include "base/vector.h"
#include "io/mesh_source.h"
#include "io/output_file.h"

namespace tetfusion {

// Writes a map (io/map_file.h) to `file`, which the caller commits. `result` is where the result
// can be read; original_ids has the number, in a stream of the original, of each of its points that
// is one of the original's, and -1 for the others; `sides` as for compare_meshes().
//
// - A point of the original that stayed lies where it stayed; any other in the tetrahedron that
//   holds it, or, outside of the result, at the nearest point of its boundary.
// - A point of the result that is one of the original's takes its value; any other what the
//   original has at its place, interpolated in the first tetrahedron that holds it, or, outside, at
//   the nearest point of the boundary.
//
// The same bytes for any number of threads. The original is read in windows; in memory are the
// result and the original's boundary triangles. Throws what reading throws, Error(kBadInput) where
// a mesh has no boundary, Error(kIo) and Error(kInterrupted).
void make_map(MeshSource* original, const std::string& result,
              const Vector<std::int64_t>& original_ids, std::uint64_t sides, OutputFile* file,
              const RunContext& context);

// Bytes of memory that takes beside what comparing the two meshes does, for each point of the
// result.
inline constexpr std::uint64_t kMapPointBytes = 190;

}  // namespace tetfusion
