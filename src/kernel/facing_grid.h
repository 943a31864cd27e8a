// Which ways the boundary surface looks, roughly where: enough to know that a part of it that rises
// will not meet another part across a gap. Its size does not depend on the mesh.
#pragma once

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

class FacingGrid {
 public:
  // Over a box, with nothing in it: 1 MiB.
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

  const Vector<std::uint32_t>& cells() const { return cells_; }
  Vector<std::uint32_t>& cells() { return cells_; }
  const FacingBox& box() const { return box_; }
  FacingBox& box() { return box_; }

 private:
  template <class Visit>
  void visit(const FacingBox& box, Visit visit) const;

  FacingBox box_;
  Vector<std::uint32_t> cells_;  // a bit a direction: 24 of them, four on each side of a cube
};

}  // namespace tetfusion
