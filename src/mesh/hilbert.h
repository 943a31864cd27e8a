// The Hilbert curve in three dimensions: points that are near on the curve are near in space.
#pragma once

#include <cstdint>

namespace tetfusion {

inline constexpr int kHilbertBits = 20;  // an axis, at most

// Position along the curve of the cell (x, y, z) in a grid of 2^bits cells a side. `bits` is even,
// and up to kHilbertBits; a key has 3 * bits.
std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z,
                          int bits = kHilbertBits);

}  // namespace tetfusion
