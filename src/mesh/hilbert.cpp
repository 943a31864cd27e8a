#include "mesh/hilbert.h"

#include <array>

namespace tetfusion {

namespace {

// The curve through a cube visits its eight octants along a Gray code, rotated and mirrored so that
// it enters at corner `entry` and leaves along axis `direction` (Hamilton & Rau-Chaplin 2008,
// "Compact Hilbert indices", sections 2.1-2.4). There are 8 x 3 such states.
constexpr unsigned kAxes = 3;

constexpr unsigned rotate_left(unsigned bits, unsigned by) {
  by %= kAxes;
  return ((bits << by) | (bits >> (kAxes - by))) & 7u;
}
constexpr unsigned rotate_right(unsigned bits, unsigned by) {
  return rotate_left(bits, kAxes - by % kAxes);
}
constexpr unsigned gray(unsigned i) { return i ^ (i >> 1); }
constexpr unsigned gray_inverse(unsigned g) { return (g ^ (g >> 1) ^ (g >> 2)) & 7u; }
constexpr unsigned trailing_ones(unsigned i) {
  unsigned n = 0;
  for (; i & 1u; i >>= 1) ++n;
  return n;
}
constexpr unsigned entry_of(unsigned place) { return place == 0 ? 0 : gray(2 * ((place - 1) / 2)); }
constexpr unsigned direction_of(unsigned place) {
  if (place == 0) return 0;
  return trailing_ones(place % 2 == 0 ? place - 1 : place) % kAxes;
}

struct Step {
  std::uint8_t place;  // on the curve
  std::uint8_t next;   // the state inside: entry * 3 + direction
};
constexpr unsigned kStates = 24;

constexpr Step step_into(unsigned state, unsigned octant) {
  const unsigned entry = state / kAxes;
  const unsigned direction = state % kAxes;
  const unsigned place = gray_inverse(rotate_right(octant ^ entry, direction + 1));
  const unsigned next_entry = entry ^ rotate_left(entry_of(place), direction + 1);
  const unsigned next_direction = (direction + direction_of(place) + 1) % kAxes;
  return {static_cast<std::uint8_t>(place),
          static_cast<std::uint8_t>(next_entry * kAxes + next_direction)};
}

// Two levels at a time: an octant and one inside it.
using Table = std::array<std::array<Step, 64>, kStates>;

constexpr Table make_table() {
  Table table{};
  for (unsigned state = 0; state < kStates; ++state) {
    for (unsigned outer = 0; outer < 8; ++outer) {
      const Step first = step_into(state, outer);
      for (unsigned inner = 0; inner < 8; ++inner) {
        const Step second = step_into(first.next, inner);
        table[state][outer << 3 | inner] = {
            static_cast<std::uint8_t>(first.place << 3 | second.place), second.next};
      }
    }
  }
  return table;
}
constexpr Table kTable = make_table();

// Bit i goes to bit 3 i.
constexpr std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x1F00000000FFFFu;
  bits = (bits | bits << 16) & 0x1F0000FF0000FFu;
  bits = (bits | bits << 8) & 0x100F00F00F00F00Fu;
  bits = (bits | bits << 4) & 0x10C30C30C30C30C3u;
  return (bits | bits << 2) & 0x1249249249249249u;
}

}  // namespace

std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits) {
  const std::uint64_t octants = spread(x) | spread(y) << 1 | spread(z) << 2;
  std::uint64_t key = 0;
  unsigned state = 0;
  for (int shift = 3 * bits - 6; shift >= 0; shift -= 6) {
    const Step step = kTable[state][octants >> shift & 63u];
    key = key << 6 | step.place;
    state = step.next;
  }
  return key;
}

}  // namespace tetfusion
