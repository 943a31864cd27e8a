#include "compare/point.h"

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

std::uint32_t morton_key(const Point& p, const PointBox& box) {
  return spread(step_of(p.x, box.low.x, box.high.x)) |
         spread(step_of(p.y, box.low.y, box.high.y)) << 1 |
         spread(step_of(p.z, box.low.z, box.high.z)) << 2;
}

Vector<std::uint32_t> sorted_by_key(const Vector<std::uint32_t>& keys) {
  constexpr std::uint32_t kDigit = (1u << kAxisBits) - 1;
  Vector<std::uint32_t> order = count_up<std::uint32_t>(keys.size()), sorted(keys.size());
  for (int shift = 0; shift < 3 * kAxisBits; shift += kAxisBits) {
    std::array<std::size_t, kDigit + 2> begins{};
    for (const std::uint32_t key : keys) ++begins[(key >> shift & kDigit) + 1];
    for (std::size_t d = 0; d <= kDigit; ++d) begins[d + 1] += begins[d];
    for (const std::uint32_t i : order) sorted[begins[keys[i] >> shift & kDigit]++] = i;
    order.swap(sorted);
  }
  return order;
}

}  // namespace tetfusion
