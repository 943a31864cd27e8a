// What a run has to write: one mesh, or several on the way to the last.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driver/request/options.h"

namespace tetfusion {

// A mesh to write on the way, or at the end.
struct Stage {
  std::optional<std::uint64_t> tets;  // go on until so many are left; absent: until nothing fuses
  std::string path;
  std::string map;  // of the file that says where points went; empty: none is wanted
};

// The stages for a mesh of so many tetrahedra, ascending by reduction; at least one.
std::vector<Stage> plan_stages(const SimplifyRequest& request, std::uint64_t tets);

// Throws Error(kUsage) where the last level of a mesh of at most so many tetrahedra goes further
// than --tets.
void check_levels(const SimplifyRequest& request, std::uint64_t tets);

}  // namespace tetfusion
