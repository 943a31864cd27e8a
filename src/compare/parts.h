// The parts of two meshes: what hangs together by points. Where parts touch without points in
// common, as in a contact, a place lies in both, and only its part tells what belongs there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/union_find.h"
#include "base/vector.h"
#include "compare/point.h"

namespace tetfusion {

inline constexpr std::uint32_t kAnyPart = std::numeric_limits<std::uint32_t>::max();
// Of a mesh with more, as where each cell has points of its own, none is told from the others.
inline constexpr std::uint32_t kMostParts = std::uint32_t{1} << 16;

// What a part is recognised by.
struct PartFigures {
  PointBox box;
  double volume = 0;
  Point moment{};  // the sum of the tetrahedra's volumes times their centres

  void add(const Corners& corners);
};

// For each of the parts `from` the one of `to` that is most like it in its box, its centre and its
// volume; kAnyPart where several are most like the same one. Empty where there are not as many of
// both, or only one.
Vector<std::uint32_t> find_counterparts(std::span<const PartFigures> from,
                                        std::span<const PartFigures> to);

// What tetrahedra join.
class PartFinder {
 public:
  explicit PartFinder(std::size_t points) : sets_(points), points_(points) {}

  void add(std::span<const Tet> tets);  // by several threads

  // The part of each point, counted from 0 on by their first points, without those that are not
  // used: kAnyPart. When all tetrahedra have been added.
  template <class IsUsed>
  Vector<std::uint32_t> parts(IsUsed is_used, std::uint32_t* count) {
    Vector<std::uint32_t> part_of(points_);
    *count = 0;
    for (std::uint32_t p = 0; p < points_; ++p) {
      const std::uint32_t root = sets_.find(p);  // the first of its part
      part_of[p] = !is_used(p) ? kAnyPart : root == p ? (*count)++ : part_of[root];
    }
    return part_of;
  }

 private:
  UnionFind sets_;
  std::size_t points_;
};

}  // namespace tetfusion
