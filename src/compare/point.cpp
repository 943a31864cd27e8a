#include "compare/point.h"

#include <array>
#include <utility>
#include <vector>

#include "mesh/blocks.h"

namespace tetfusion {

namespace {

constexpr int kAxisBits = 10;

std::uint32_t step_of(double x, double low, double high) {
  constexpr double kSteps = 1 << kAxisBits;
  const double share = high > low ? (x - low) / (high - low) : 0;
  return static_cast<std::uint32_t>(std::clamp(share * kSteps, 0.0, kSteps - 1));
}

// Bit i to bit 3 i.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000FFu;
  bits = (bits | bits << 8) & 0x0300F00Fu;
  bits = (bits | bits << 4) & 0x030C30C3u;
  return (bits | bits << 2) & 0x09249249u;
}

}  // namespace

PointBox box_of(std::span<const Point> points) {
  PointBox box;
  for (const Point& p : points) box.add(p);
  return box;
}

std::uint32_t morton_key(const Point& p, const PointBox& box) {
  return spread(step_of(p.x, box.low.x, box.high.x)) |
         spread(step_of(p.y, box.low.y, box.high.y)) << 1 |
         spread(step_of(p.z, box.low.z, box.high.z)) << 2;
}

// By one digit after the other, the lowest first, each time in blocks: first how often each of them
// has each digit, and so where it begins to put those.
Vector<std::uint32_t> sorted_by_key(const Vector<std::uint32_t>& keys) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  constexpr std::size_t kDigits = std::size_t{1} << kAxisBits;
  Vector<std::uint32_t> order = count_up<std::uint32_t>(keys.size()), sorted(keys.size());
  std::vector<std::array<std::uint32_t, kDigits>> places(block_count(keys.size(), kBlock));
  for (int shift = 0; shift < 3 * kAxisBits; shift += kAxisBits) {
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
