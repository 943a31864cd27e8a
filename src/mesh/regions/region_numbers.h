// Which tetrahedra are in one region: those with the same values in some cell arrays.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "base/vector.h"
#include "mesh/data_array.h"

namespace tetfusion {

// Equal for values that mean the same region, and for no others of their type: -0 is 0, and what is
// no number is all alike. By bits, as a processor may be told to take the smallest numbers for 0.
template <class T>
std::uint64_t region_key(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    constexpr Bits kSign = Bits{1} << (8 * sizeof(T) - 1);
    constexpr auto kInfinite = std::bit_cast<Bits>(std::numeric_limits<T>::infinity());
    const auto bits = std::bit_cast<Bits>(value);
    const Bits magnitude = bits & ~kSign;
    if (magnitude == 0) return 0;
    return magnitude > kInfinite ? kInfinite + 1 : bits;
  } else {
    return static_cast<std::make_unsigned_t<T>>(value);
  }
}

// Of each value.
Vector<std::uint64_t> region_keys(ValueType type, std::span<const std::byte> values);

// Numbers regions in the order in which they come up. Takes 43 bytes a region at most, half as much
// again while it grows.
class RegionNumbers {
 public:
  // The number of what has that key inside what had the number `before`.
  std::uint32_t number(std::uint32_t before, std::uint64_t key);
  std::size_t size() const { return count_; }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  struct Slot {
    std::uint64_t key;
    std::uint32_t before;
    std::uint32_t number;  // kNone: free
  };
  Slot& find(std::uint32_t before, std::uint64_t key);
  void grow();

  Vector<Slot> slots_;  // a power of two
  std::uint32_t count_ = 0;
};

}  // namespace tetfusion
