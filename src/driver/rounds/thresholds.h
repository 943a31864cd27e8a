// What the fusions of a round may cost: from round to round more, and the same for every chunk.
#pragma once

#include <cstdint>
#include <optional>

#include "kernel/costs.h"

namespace tetfusion {

struct Threshold {
  double cost = 0;             // 0 before the first round that fuses
  bool quota_was_met = false;  // the round ended with its quota, not with what the cost allowed
};

// The threshold after the last one: four times as much (twice the error), or what half of the
// vertices can be fused for, whichever is more; less where less is enough for what has to go.
double next_threshold(const CostHistogram& costs, const Threshold& last,
                      std::optional<std::uint64_t> tets_to_go);

// What the gradients' variance (FuseLimits) is to cost a fusion across a typical edge, where
// `costs` are those of the mesh as it was read: more than fusions do where the fields hardly bend,
// and, if they bend more elsewhere, less than the last ones on the way to the goal, so that it
// decides between the former alone; less where none of these bends a field, and all costs what its
// length does, as the typical edge, `length_cost`; and never more than `most`. 0 where no vertex
// costs anything.
double cost_of_variance(const CostHistogram& costs, std::optional<std::uint64_t> tets_to_go,
                        double length_cost, double most);

// No vertex costs more; 0 without vertices.
double largest_cost(const CostHistogram& costs);

}  // namespace tetfusion
