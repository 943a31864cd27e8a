// The Hilbert curve in three dimensions: points that are near on the curve are near in space.
#pragma once

#include <cstdint>

namespace tetfusion {

inline constexpr int kHilbertBits = 20;  // bits an axis; a key has 60

// Position along the curve of the cell (x, y, z) in a grid of 2^20 cells a side.
std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

}  // namespace tetfusion
