// How far a surface moves where some of its triangles give way to a fan, as a bound that holds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kernel/point3.h"

namespace tetfusion {

// A patch of triangles, wound the same way, and the fan that takes its place: from the apex to each
// edge of the chain. Both have the same outline: the chain, if it is closed (it returns to its
// first point, which is not repeated), else the chain and the way from its last point over the apex
// to its first one. Coordinates are small: about a point of the patch.
struct PatchChange {
  std::vector<Triangle3> triangles;
  std::vector<std::array<Point3, 2>> edges;  // of triangles; some may be of the outline
  std::vector<Point3> points;                // corners of triangles that are not on the outline
  Point3 apex{};
  std::vector<Point3> chain;
  bool closed = true;

  void clear() {
    triangles.clear();
    edges.clear();
    points.clear();
    chain.clear();
  }
};

struct PatchDistance {
  double distance = 0;  // at most so far is any point of one from its image on the other
  double rise = 0;      // the fan is at most so far above the patch, along the normal
  Point3 normal{};      // the mean one of the patch
};

// Both are graphs over the same polygon, seen along the mean normal of the patch, if all triangles
// show their front: the image of a point is then the one above or below it. The height between the
// two is piecewise linear, so it is largest where an edge of one crosses an edge of the other, or
// at a corner. Nothing, if they are no such graphs, or if a triangle of the fan is tilted by more
// than 60 degrees.
std::optional<PatchDistance> measure(const PatchChange& change);

enum class Side : std::uint8_t { kBehind, kBefore };

// Seen along a direction to which another triangle shows its front: does what lies before or behind
// it of a triangle lie on this side of its plane alone? What is nearer to its outline than `margin`
// does not count, so that neighbours may touch it, but none may lie in the plane, as the other side
// of a contact does: in the mean it must be further away than the margin. False where the other one
// shows its back.
bool lies_on_side(const Triangle3& triangle, const Triangle3& other, const Point3& direction,
                  Side side, double margin);

// The point of a segment that is nearest to x.
Point3 nearest_on_segment(const Point3& x, const Point3& from, const Point3& to);

}  // namespace tetfusion
