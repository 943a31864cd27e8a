// What an inspection keeps of each cell.
#pragma once

#include <cstdint>

namespace tetfusion {

// Bits.
enum CellState : std::uint8_t { kSound = 0, kNoVolume = 1, kRewound = 2 };

}  // namespace tetfusion
