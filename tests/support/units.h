// Units of what tests measure.
#pragma once

#include <cstdint>

namespace tetfusion::testing {

inline constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

}  // namespace tetfusion::testing
