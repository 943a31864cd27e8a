// Points of the original mesh that are no vertices any more. Each lies in a tetrahedron, and goes
// where that goes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

inline constexpr std::uint32_t kNoPoint = 0xFFFFFFFFu;

template <class Real>
struct RemovedPoints {
  Vector<Vec3<Real>> positions;
  Vector<double> values;       // what the original's steering values were: a row a point
  Vector<std::uint32_t> next;  // in the same tetrahedron; kNoPoint: it is the last one
  // Of each tetrahedron; kNoPoint: it has none. Empty: nobody wants to know of removed points.
  Vector<std::uint32_t> first;

  std::size_t size() const { return positions.size(); }
  bool wanted() const { return !first.empty(); }

  // Nobody wants to know of any.
  void clear() {
    positions.clear();
    values.clear();
    next.clear();
    first.clear();
  }

  // So many tetrahedra, and no point.
  void reset(std::size_t tets) {
    clear();
    first.assign(tets, kNoPoint);
  }

  // Points that are in no list yet. Returns the first one's id.
  std::uint32_t add(std::size_t points, std::size_t width) {
    const std::size_t before = size();
    positions.resize(before + points);
    values.resize((before + points) * width);
    next.resize(before + points);
    return static_cast<std::uint32_t>(before);
  }

  // Puts a point that is in no list in front of a tetrahedron's.
  void push(std::uint32_t tet, std::uint32_t point) {
    next[point] = first[tet];
    first[tet] = point;
  }
};

}  // namespace tetfusion
