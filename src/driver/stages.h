// What a run has to write: one mesh, or several on the way to the last.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driver/options.h"

namespace tetfusion {

// Throws Error(kUsage) for options that contradict each other.
void check_options(const SimplifyRequest& request);

// A mesh to write on the way, or at the end.
struct Stage {
  std::optional<std::uint64_t> tets;  // go on until so many are left; absent: until nothing fuses
  std::string path;
  std::string map;  // of the file that says where points went; empty: none is wanted
};

// Throws Error(kUsage) where one of the files that the input consists of would be written over
// while it is needed (a piece takes the mesh with it whose piece it is), or a map one of the other
// files.
void refuse_outputs_among(const MeshDescription& mesh, const SimplifyRequest& request);

// The stages for a mesh of so many tetrahedra, ascending by reduction; at least one.
std::vector<Stage> plan_stages(const SimplifyRequest& request, std::uint64_t tets);

// How much of a run is done when it has come from `first` tetrahedra to `tets`, in so many rounds.
// Without a goal nobody knows where they will end; most of what goes does so in the first ones.
double share_done(std::uint64_t first, std::uint64_t tets, const std::optional<std::uint64_t>& goal,
                  std::size_t rounds);

}  // namespace tetfusion
