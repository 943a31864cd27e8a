#include "driver/notices.h"

#include <fmt/format.h>

#include <string_view>

#include "base/numbers.h"

namespace tetfusion {

std::string boundary_name(const BehaviourOptions& b) {
  if (b.boundary == Boundary::kWithin) return fmt::format("{}", b.boundary_distance);
  return b.boundary == Boundary::kPlanar ? "planar" : "exact";
}

void say_what_steers(const std::vector<std::string>& arrays, const RunContext& context) {
  for (const std::string& name : arrays) {
    context.say(fmt::format("array {} steers (--array chooses others)", name));
  }
}

void say_what_is_odd(const InputFacts& facts, const std::vector<std::string>& regions,
                     const RunContext& context) {
  const auto say = [&](std::uint64_t count, std::string_view what) {
    if (count > 0) context.say(fmt::format("{} {}", format_count(count), what));
  };
  say(facts.rewound, "tetrahedra were wound the other way: rewound");
  say(facts.degenerate, "tetrahedra have no volume: they and their vertices stay as they are");
  say(facts.inverted, "tetrahedra are inverted: they and their vertices stay as they are");
  say(facts.duplicate_tets,
      "tetrahedra are duplicates of others: they and their vertices stay as they are");
  say(facts.nonconforming_faces, "faces do not conform: their tetrahedra stay as they are");
  say(facts.nonmanifold_edges, "boundary edges are not manifold: they stay as they are");
  say(facts.unused_points, "points are used by no cell: dropped");
  say(facts.merged_points, "points at the seams of pieces were merged");
  say(facts.ghost_cells, "ghost cells were dropped");
  for (const std::string& name : regions) {
    context.say(fmt::format(
        "interfaces of cell array {} are kept (--regions none switches that off)", name));
  }
}

}  // namespace tetfusion
