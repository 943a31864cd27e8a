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
#include "kernel/point3.h"

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

  // Notes a triangle of the boundary, whose normal points out, in all cells that it touches.
  // Thread-safe; the order does not matter.
  void note(const Point3& a, const Point3& b, const Point3& c);

  // Whether a triangle that looks against the direction, at more than a right angle, may have been
  // noted in a cell that the box touches.
  bool may_face(const FacingBox& box, const Point3& direction) const;

  // Whether all triangles that may have been noted in these cells look, with their fronts, into one
  // half of all directions: the surface there is then a graph, and has one sheet alone.
  bool looks_one_way(const FacingBox& box) const;

  // Of cells along each axis, both ends among them.
  struct Range {
    std::array<std::size_t, 3> first, last;
    std::size_t count() const {
      return (last[0] - first[0] + 1) * (last[1] - first[1] + 1) * (last[2] - first[2] + 1);
    }
  };
  // The cells that a box touches; what is outside counts to the nearest one.
  Range range_of(const FacingBox& box) const {
    return range_round(in_cells(box.lo), in_cells(box.hi));
  }
  // Calls visit(cell) with these, until it says true.
  template <class Visit>
  void visit(const FacingBox& box, Visit visit) const {
    visit_range(range_of(box), visit);
  }
  // The same of any grid of kRow cells along each axis; whether it has said true.
  template <std::size_t kRow = kCells, class Visit>
  static bool visit_range(const Range& range, Visit& visit);
  // With those that a triangle touches, and some nearby; with some of them more than once. In
  // whatever order its corners come.
  template <class Visit>
  void visit_triangle(const Triangle3& triangle, Visit visit) const;
  // How many triangles have been noted in a cell, or how often.
  std::uint64_t count(std::size_t cell) const { return cells_[cell] >> kBins; }

  const Vector<std::uint64_t>& cells() const { return cells_; }
  Vector<std::uint64_t>& cells() { return cells_; }
  const FacingBox& box() const { return box_; }
  FacingBox& box() { return box_; }

 private:
  Point3 in_cells(const Point3& p) const;
  static Range range_round(const Point3& lo, const Point3& hi);
  static std::array<Triangle3, 2> halves(const Triangle3& triangle);
  // Of a triangle, about.
  static double cells_touched(const Triangle3& triangle);
  template <class Visit>
  static bool visit_part(const Triangle3& part, Visit& visit);

  FacingBox box_;
  Vector<std::uint64_t> cells_;  // a bit a bin, and above these the number of triangles
};

template <std::size_t kRow, class Visit>
bool FacingGrid::visit_range(const Range& range, Visit& visit) {
  for (std::size_t z = range.first[2]; z <= range.last[2]; ++z) {
    for (std::size_t y = range.first[1]; y <= range.last[1]; ++y) {
      for (std::size_t x = range.first[0]; x <= range.last[0]; ++x) {
        if (visit((z * kRow + y) * kRow + x)) return true;
      }
    }
  }
  return false;
}

template <class Visit>
void FacingGrid::visit_triangle(const Triangle3& triangle, Visit visit) const {
  Triangle3 corners{in_cells(triangle[0]), in_cells(triangle[1]), in_cells(triangle[2])};
  std::sort(corners.begin(), corners.end());
  visit_part(corners, visit);
}

// Where the box round a long, oblique one has far more cells than it touches itself, that of each
// half.
template <class Visit>
bool FacingGrid::visit_part(const Triangle3& part, Visit& visit) {
  constexpr std::size_t kFew = 8;
  constexpr double kMany = 4;
  const FacingBox box = box_round(part[0], part[1], part[2]);
  const Range range = range_round(box.lo, box.hi);
  if (range.count() > kFew && static_cast<double>(range.count()) > kMany * cells_touched(part)) {
    const auto [one, other] = halves(part);
    return visit_part(one, visit) || visit_part(other, visit);
  }
  return visit_range(range, visit);
}

}  // namespace tetfusion
