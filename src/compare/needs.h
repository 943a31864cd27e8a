// What comparing two meshes takes of memory.
#pragma once

#include <algorithm>
#include <cstdint>

#include "io/source/mesh_source.h"

namespace tetfusion {

// Bytes of memory, beside what the process has anyway: what is needed in any case, and for sides
// (compare_meshes()).
struct ComparisonNeeds {
  std::uint64_t fixed = 0, least_sides = 0, most_sides = 0;

  std::uint64_t least() const { return fixed + least_sides; }
  std::uint64_t most() const { return fixed + most_sides; }
  // The sides that so many bytes leave room for.
  std::uint64_t sides_within(std::uint64_t bytes) const {
    return std::clamp(bytes > fixed ? bytes - fixed : 0, least_sides, most_sides);
  }
};

// With a simplified mesh of so many tetrahedra and points; `boundary_triangles` are those of both
// boundaries, and of interfaces if these are looked at.
ComparisonNeeds estimate_comparison(const MeshDescription& original, std::uint64_t tets,
                                    std::uint64_t points, std::uint64_t boundary_triangles);

// The memory for sides that is left if the process may have `total` bytes. Throws Error(kMemory)
// with what is needed where that is not enough, and what opening a stream throws.
std::uint64_t plan_comparison(MeshSource* original, MeshSource* simplified, std::uint64_t total);

}  // namespace tetfusion
