// Triangles in space: the boundary of a mesh, and what lies nearest on it.
#pragma once

#include <array>
#include <cstdint>

#include "base/vector.h"
#include "compare/parts.h"
#include "compare/point.h"
#include "mesh/box_tree.h"

namespace tetfusion {

// What is nearest to a point on a triangle: the weights of its corners, 0 to 1, which sum to 1, and
// the square of the distance. Right for triangles without area, too.
struct NearestOnTriangle {
  std::array<double, 3> weights;
  double squared;
};
NearestOnTriangle nearest_on_triangle(const Point& p, const std::array<Point, 3>& corners);

// The boundary triangles of a mesh, with the points that they use.
struct TriangleSet {
  Vector<Point> points;
  Vector<VertexId> point_ids;  // which points of the mesh; empty where nobody knows
  Vector<std::array<std::uint32_t, 3>> triangles;
  // Of the points: which part of the mesh they belong to, or of the one that it is held against;
  // empty where that does not matter.
  Vector<std::uint32_t> parts;

  std::array<Point, 3> corners(std::size_t t) const {
    const auto& ids = triangles[t];
    return {points[ids[0]], points[ids[1]], points[ids[2]]};
  }
  std::uint32_t part_of_point(std::size_t p) const { return parts.empty() ? kAnyPart : parts[p]; }
  std::uint32_t part_of(std::size_t t) const { return part_of_point(triangles[t][0]); }
};

// Puts the triangles into an order that keeps neighbours together, and returns which they were.
Vector<std::uint32_t> order_triangles(TriangleSet* set);

// The nearest of a set of ordered triangles, which must outlive this. Const functions may be called
// from several threads.
class TriangleFinder {
 public:
  explicit TriangleFinder(const TriangleSet* set);

  struct Found {
    std::uint32_t triangle;
    NearestOnTriangle nearest;
  };
  // Of those of a part, if it has any, else of all. The set must not be empty. Where several are
  // equally near, which one is returned depends on `hint`, any triangle: the nearer it is, the
  // faster this is.
  Found nearest(const Point& p, std::uint32_t hint, std::uint32_t part = kAnyPart) const;

 private:
  NearestOnTriangle nearest_if(const Point& p, std::uint32_t triangle, std::uint32_t part) const;

  const TriangleSet& set_;
  BoxTree tree_;
};

// Distances from points of a surface to another one.
struct OneSidedDistance {
  double max = 0;
  Point max_at{};   // where on the surface that it is from
  double mean = 0;  // over the area
  double area = 0;  // of the surface that it is from
};
struct SurfaceDistance {
  bool identical = false;  // the same triangles, by coordinates
  Point differs_at{};      // else: the centre of one that only one of them has
  OneSidedDistance first_to_second, second_to_first;
};

// From the corners and the centres of the triangles of each to the other, part to part. Where only
// one is empty distances are infinite.
// Deterministic for any number of threads.
SurfaceDistance measure_surfaces(const TriangleSet& first, const TriangleSet& second);

}  // namespace tetfusion
