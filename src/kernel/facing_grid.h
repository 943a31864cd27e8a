// Which ways the boundary surface looks, roughly where: enough to know that a part of it that rises
// will not meet another part across a gap. Its size does not depend on the mesh. Where it cannot
// tell what is across a gap from what is the other side of a wall, the triangles themselves can
// (boundary_triangles.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "kernel/patch_distance.h"

namespace tetfusion {

struct FacingBox {
  Point3 lo{}, hi{};
  void add(const Point3& p);
  void widen(double by);
};

inline FacingBox box_round(const Point3& a, const Point3& b, const Point3& c) {
  FacingBox box{a, a};
  box.add(b);
  box.add(c);
  return box;
}

class FacingGrid {
 public:
  static constexpr std::size_t kCells = 64;  // along each axis
  static constexpr unsigned kBins = 24;      // of directions: four on each side of a cube

  // Over a box, with nothing in it: 2 MiB.
  void reset(const FacingBox& box);
  bool empty() const { return cells_.empty(); }

  // Notes a triangle of the boundary, whose normal points out, in all cells that its box touches.
  // Thread-safe; the order does not matter.
  void note(const Point3& a, const Point3& b, const Point3& c);

  // Whether a triangle that looks against the direction, at more than a right angle, may have been
  // noted in a cell that the box touches.
  bool may_face(const FacingBox& box, const Point3& direction) const;

  // Whether all triangles that may have been noted in these cells look, with their fronts, into one
  // half of all directions: the surface there is then a graph, and has one sheet alone.
  bool looks_one_way(const FacingBox& box) const;

  // Calls visit(cell) with the cells that a box touches (what is outside counts to the nearest
  // one), until it says true.
  template <class Visit>
  void visit(const FacingBox& box, Visit visit) const;
  // How many triangles have been noted in a cell.
  std::uint64_t count(std::size_t cell) const { return cells_[cell] >> kBins; }

  const Vector<std::uint64_t>& cells() const { return cells_; }
  Vector<std::uint64_t>& cells() { return cells_; }
  const FacingBox& box() const { return box_; }
  FacingBox& box() { return box_; }

 private:
  FacingBox box_;
  Vector<std::uint64_t> cells_;  // a bit a bin, and above these the number of triangles
};

template <class Visit>
void FacingGrid::visit(const FacingBox& box, Visit visit) const {
  std::array<std::size_t, 3> first{}, last{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double width = box_.hi[i] - box_.lo[i];
    const auto at = [&](double x) {
      const double share = width > 0 ? (x - box_.lo[i]) / width : 0;
      return static_cast<std::size_t>(std::clamp(share * double{kCells}, 0.0, kCells - 1.0));
    };
    first[i] = at(box.lo[i]);
    last[i] = at(box.hi[i]);
  }
  for (std::size_t z = first[2]; z <= last[2]; ++z) {
    for (std::size_t y = first[1]; y <= last[1]; ++y) {
      for (std::size_t x = first[0]; x <= last[0]; ++x) {
        if (visit((z * kCells + y) * kCells + x)) return;
      }
    }
  }
}

}  // namespace tetfusion
