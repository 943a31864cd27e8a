// What an inspection keeps of each cell.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "base/vector.h"
#include "mesh/faces.h"
#include "mesh/predicates.h"

namespace tetfusion {

class CellStates {
 public:
  void resize(std::size_t cells) { states_.resize(cells); }

  // Judges a cell, and rewinds it if it is wound the other way. Returns six times its volume, 0 if
  // it has none. Different cells may be judged at the same time.
  template <class P>
  double judge(const P& points, TetId t, Tet* corners) {
    const Determinant det = determinant(points, *corners);
    const int sign = names_vertex_twice(*corners) ? 0 : det.sign();
    states_[t] = sign > 0 ? kSound : (sign < 0 ? kRewound : kNoVolume);
    if (sign < 0) std::swap((*corners)[2], (*corners)[3]);
    return sign == 0 ? 0 : std::abs(det.value);
  }

  bool has_volume(TetId t) const { return states_[t] != kNoVolume; }
  bool is_rewound(TetId t) const { return states_[t] == kRewound; }

  // Do two cells of a face lie on the same side of it? The copies of one cell do not count: they
  // are duplicates.
  bool fold(const FaceSide& a, const FaceSide& b) const {
    return a.odd == b.odd && a.apex != b.apex && has_volume(a.tet) && has_volume(b.tet);
  }

 private:
  enum State : std::uint8_t { kSound, kNoVolume, kRewound };
  Vector<std::uint8_t> states_;
};

}  // namespace tetfusion
