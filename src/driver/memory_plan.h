// What a run needs of memory and disk, estimated before it begins.
#pragma once

#include <cstdint>

#include "io/mesh_source.h"

namespace tetfusion {

struct MemoryNeeds {
  // Bytes of the mesh as pieces: what the run keeps in memory, or on disk.
  std::uint64_t pieces = 0;
  std::uint64_t in_core = 0;      // resident at most, with the mesh in memory
  std::uint64_t out_of_core = 0;  // resident at most, with the mesh on disk
  std::uint64_t scratch = 0;      // of the disk, beside the output, where the mesh is kept there
};

// `steering_bytes` are those that steering takes a vertex; `memory_to_read` is what the reader
// itself keeps in memory: 0 where it reads in windows.
MemoryNeeds estimate_needs(const MeshDescription& mesh, std::uint64_t steering_bytes,
                           std::uint64_t chunk_tets, int threads, std::uint64_t memory_to_read);

}  // namespace tetfusion
