// Which ways the boundary surface looks, roughly where: enough to know that a part of it that rises
// will not meet another part across a gap. Its size does not depend on the mesh.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "kernel/patch_distance.h"

namespace tetfusion {

struct PointBox {
  Point3 lo{}, hi{};
  void add(const Point3& p);
  void widen(double by);
};

class FacingGrid {
 public:
  // Over a box, with nothing in it: 1 MiB.
  void reset(const PointBox& box);
  bool empty() const { return cells_.empty(); }

  // Notes a triangle of the boundary, whose normal points out, in all cells that its box touches.
  // Thread-safe; the order does not matter.
  void note(const Point3& a, const Point3& b, const Point3& c);

  // Whether a triangle that looks against the direction, at more than a right angle, may have been
  // noted in a cell that the box touches.
  bool may_face(const PointBox& box, const Point3& direction) const;

  const Vector<std::uint32_t>& cells() const { return cells_; }
  Vector<std::uint32_t>& cells() { return cells_; }
  const PointBox& box() const { return box_; }
  PointBox& box() { return box_; }

 private:
  template <class Visit>
  void visit(const PointBox& box, Visit visit) const;

  PointBox box_;
  Vector<std::uint32_t> cells_;  // a bit a direction: 24 of them, four on each side of a cube
};

}  // namespace tetfusion
