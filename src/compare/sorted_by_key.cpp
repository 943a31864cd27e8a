#include "compare/sorted_by_key.h"

#include <array>
#include <utility>
#include <vector>

#include "base/blocks.h"

namespace tetfusion {

// By one digit after the other, the lowest first, each time in blocks: first how often each of them
// has each digit, and so where it begins to put those.
Vector<std::uint32_t> sorted_by_key(const Vector<std::uint32_t>& keys, int bits) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  constexpr int kDigitBits = 12;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  Vector<std::uint32_t> order = count_up<std::uint32_t>(keys.size()), sorted(keys.size());
  std::vector<std::array<std::uint32_t, kDigits>> places(block_count(keys.size(), kBlock));
  for (int shift = 0; shift < bits; shift += kDigitBits) {
    const auto digit_of = [&](std::uint32_t i) { return keys[i] >> shift & (kDigits - 1); };
    for_each_block(keys.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
      places[b].fill(0);
      for (std::size_t i = begin; i < end; ++i) ++places[b][digit_of(order[i])];
    });
    std::uint32_t sum = 0;
    for (std::size_t digit = 0; digit < kDigits; ++digit) {
      for (auto& block : places) sum += std::exchange(block[digit], sum);
    }
    for_each_block(keys.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) sorted[places[b][digit_of(order[i])]++] = order[i];
    });
    order.swap(sorted);
  }
  return order;
}

}  // namespace tetfusion
