// A refined mesh as a file.
#pragma once

#include <functional>
#include <string>

#include "io/progressive/progressive_file.h"
#include "io/write_mesh.h"
#include "refine/refinable_mesh.h"

namespace tetfusion {

// What the points' numbers in the file take beside the mesh.
struct LevelNumbers {
  static std::uint64_t bytes_for(const ProgressiveCounts& counts) {
    return counts.points * sizeof(std::int64_t);
  }
};

// Points and cells in the order of their numbers, all arrays, field data. Their numbers in the file
// lie where `folder` says (PagedBytes), and keep() is called each time some of the mesh has been
// read. Throws what writing throws.
void write_level(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& path,
                 const WriteOptions& options, const std::string& folder,
                 const std::function<void()>& keep);

}  // namespace tetfusion
