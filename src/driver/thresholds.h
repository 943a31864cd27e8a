// What the fusions of a round may cost: from round to round more, and the same for every chunk.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "kernel/fuse_round.h"

namespace tetfusion {

struct RoundThreshold {
  double cost = 0;
  bool last = false;  // it is enough for what has to go
};

// The next threshold: four times the last one (twice the error), or what half of the vertices can
// be fused for, whichever is more; less where less is enough for `vertices_to_go`. `previous` is 0
// before the first.
RoundThreshold next_threshold(const CostHistogram& costs, double previous,
                              std::optional<std::uint64_t> vertices_to_go);

}  // namespace tetfusion
