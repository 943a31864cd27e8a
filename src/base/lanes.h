// Four numbers at a time. Every operation rounds as it does for one number, so that what is
// computed in lanes is the same to the bit; written as templates over both, it is also the same
// code.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace tetfusion {

inline constexpr std::size_t kLanes = 4;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
using LaneMask = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));

// Two numbers in double precision.
using DoubleLanes = double __attribute__((vector_size(2 * sizeof(double))));

// Where the condition holds, a; elsewhere b. Both are computed.
inline float select(bool condition, float a, float b) { return condition ? a : b; }
inline Lanes select(LaneMask condition, Lanes a, Lanes b) { return condition ? a : b; }

// Whole numbers as numbers.
inline Lanes to_lanes(LaneMask x) { return __builtin_convertvector(x, Lanes); }

// The power of two that makes a number > 0 one in [1, 2), as far as there is such a power; of other
// numbers anything.
inline float normalizer(float x) {
  return std::bit_cast<float>((254 - (std::bit_cast<std::int32_t>(x) >> 23)) << 23);
}
inline Lanes normalizer(Lanes x) {
  return std::bit_cast<Lanes>((254 - (std::bit_cast<LaneMask>(x) >> 23)) << 23);
}

// Rows as columns.
template <class L>
inline std::array<L, kLanes> transposed(const std::array<L, kLanes>& r) {
  const L low01 = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5);
  const L low23 = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5);
  const L high01 = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7);
  const L high23 = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
  return {__builtin_shufflevector(low01, low23, 0, 1, 4, 5),
          __builtin_shufflevector(low01, low23, 2, 3, 6, 7),
          __builtin_shufflevector(high01, high23, 0, 1, 4, 5),
          __builtin_shufflevector(high01, high23, 2, 3, 6, 7)};
}

inline bool all(LaneMask condition) {
  std::array<std::uint64_t, 2> halves{};
  std::memcpy(halves.data(), &condition, sizeof condition);
  return (halves[0] & halves[1]) == ~std::uint64_t{0};
}

inline float square_root(float x) { return std::sqrt(x); }
inline Lanes square_root(Lanes x) {
#ifdef __SSE__
  return _mm_sqrt_ps(x);
#else
  Lanes root{};
  for (std::size_t i = 0; i < kLanes; ++i) root[i] = std::sqrt(x[i]);
  return root;
#endif
}

}  // namespace tetfusion
