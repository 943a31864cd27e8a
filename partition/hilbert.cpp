#include "partition/hilbert.h"

#include <array>

namespace tetfusion {

namespace {

// The curve through a cube visits its eight octants along a Gray code, rotated and mirrored so that it enters
// at corner `entry` and leaves along axis `direction` (Hamilton & Rau-Chaplin 2008, "Compact Hilbert
// indices", sections 2.1-2.4). There are 8 x 3 such states; the table holds, for state and octant, the
// octant's place on the curve and the state inside it.
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
  std::uint8_t place;
  std::uint8_t next;  // entry * 3 + direction
};
using Table = std::array<std::array<Step, 8>, 24>;

constexpr Table make_table() {
  Table table{};
  for (unsigned entry = 0; entry < 8; ++entry) {
    for (unsigned direction = 0; direction < kAxes; ++direction) {
      for (unsigned octant = 0; octant < 8; ++octant) {
        const unsigned place = gray_inverse(rotate_right(octant ^ entry, direction + 1));
        const unsigned next_entry = entry ^ rotate_left(entry_of(place), direction + 1);
        const unsigned next_direction = (direction + direction_of(place) + 1) % kAxes;
        table[entry * kAxes + direction][octant] = {
            static_cast<std::uint8_t>(place),
            static_cast<std::uint8_t>(next_entry * kAxes + next_direction)};
      }
    }
  }
  return table;
}
constexpr Table kTable = make_table();

}  // namespace

std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint64_t key = 0;
  unsigned state = 0;
  for (int bit = kHilbertBits - 1; bit >= 0; --bit) {
    const unsigned octant = ((x >> bit) & 1u) | ((y >> bit) & 1u) << 1 | ((z >> bit) & 1u) << 2;
    const Step step = kTable[state][octant];
    key = key << 3 | step.place;
    state = step.next;
  }
  return key;
}

}  // namespace tetfusion
