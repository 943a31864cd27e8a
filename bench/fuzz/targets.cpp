#include "fuzz/targets.h"

#include <algorithm>
#include <array>

namespace tetfusion::fuzz {

std::span<const Target> targets() {
  static constexpr std::array<Target, 11> kTargets{
      {{"vtu", read_vtu, vtu_seeds},
       {"pvtu", read_pvtu, pvtu_seeds},
       {"pvd", read_pvd_list, pvd_seeds},
       {"legacy", read_legacy, legacy_seeds},
       {"medit", read_medit, medit_seeds},
       {"gmsh", read_gmsh, gmsh_seeds},
       {"tetgen", read_tetgen, tetgen_seeds},
       {"chunk_store", read_chunk_store, chunk_store_seeds},
       {"map", read_map, map_seeds},
       {"progressive", read_progressive, progressive_seeds},
       {"command_line", run_command, command_seeds}}};
  return kTargets;
}

const Target* find_target(std::string_view name) {
  const auto all = targets();
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const Target& t) { return t.name == name; });
  return at == all.end() ? nullptr : &*at;
}

}  // namespace tetfusion::fuzz
