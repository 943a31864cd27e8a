// Four numbers at a time. Every operation rounds as it does for one number, so that what is
// computed in lanes is the same to the bit; written as templates over both, it is also the same
// code.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tetfusion {

inline constexpr std::size_t kLanes = 4;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

// Two numbers in double precision.
using DoubleLanes = double __attribute__((vector_size(2 * sizeof(double))));

// Where the condition holds, a; elsewhere b. Both are computed.
inline float select(bool condition, float a, float b) { return condition ? a : b; }
inline Lanes select(LaneMask condition, Lanes a, Lanes b) { return condition ? a : b; }

inline float square_root(float x) { return std::sqrt(x); }
inline Lanes square_root(Lanes x) {
  Lanes root{};
  for (std::size_t i = 0; i < kLanes; ++i) root[i] = std::sqrt(x[i]);
  return root;
}

}  // namespace tetfusion
