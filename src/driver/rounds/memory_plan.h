// What a run needs of memory and disk, estimated before it begins.
#pragma once

#include <cstdint>
#include <functional>

#include "base/run_context.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// The program, its libraries, stacks and what the allocator keeps.
inline constexpr std::uint64_t kProcessBytes = std::uint64_t{32} << 20;

// How many rows of the input a thread has in hand at a time, and what they take: `most`, or what
// has room beside all else in a budget of `total` bytes. A row takes bytes_a_row, and what is made
// of it. Results do not depend on it.
struct InputWindow {
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0;
};
InputWindow plan_window(std::uint64_t most, std::uint64_t bytes_a_row, std::uint64_t total,
                        int threads);

struct MemoryNeeds {
  // Bytes of the mesh as pieces: what the run keeps in memory, or on disk.
  std::uint64_t pieces = 0;
  std::uint64_t in_core = 0;      // resident at most, with the mesh in memory
  std::uint64_t out_of_core = 0;  // resident at most, with the mesh on disk
  std::uint64_t scratch = 0;      // of the disk, beside the output, where the mesh is kept there
};

// What a run takes beside the mesh and its arrays: of a vertex, for steering; of a tetrahedron, for
// its number (keeps_numbers()); of a point that is no vertex any more but remembered for the
// sake of a bound at points; of the values of a point and of a cell of the original that are put
// aside (original_values.h); and of the means of cell arrays at a point, all of which lie in memory
// while the input is read. 0: there are none.
struct SteeringBytes {
  std::uint64_t vertex = 0, tet = 0, removed_point = 0, point_aside = 0, point_mean = 0,
                cell_aside = 0;
  int positions_aside = 1;  // beside the values of a point
};

// Of the input's reader: what it keeps in memory, and the cells of lower dimension that it gives,
// which lie in memory all the time.
struct ReaderNeeds {
  std::uint64_t bytes = 0;
  LowerCount lower;
};

MemoryNeeds estimate_needs(const MeshDescription& mesh, const SteeringBytes& steering,
                           std::uint64_t chunk_tets, int threads, const ReaderNeeds& reader);

// What a run needs with as many threads as `memory` is enough for, but no more than thread_count().
// Where those are fewer the run is told so and uses no more: results do not depend on it. Where it
// is not enough for one thread, what that needs.
MemoryNeeds fit_threads(std::uint64_t memory,
                        const std::function<MemoryNeeds(int threads)>& needs_with,
                        const RunContext& context);

// Makes them enough for the verification of a result of so many tetrahedra, with so many bytes more
// for each of its points and each of these.
void include_verification(const MeshDescription& mesh, std::uint64_t tets,
                          std::uint64_t point_bytes, std::uint64_t tet_bytes, MemoryNeeds* needs);

}  // namespace tetfusion
