// The triangles of a sheet round two neighbours on it, and what takes their place when the two
// become one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernel/sheets/patch_distance.h"

namespace tetfusion {

// Two neighbours on a sheet: v, which is the origin, and its partner. Where they lie on a line of
// the sheet, their edge is a part of it.
struct SheetPair {
  std::vector<Point3> ring;          // of v's fan (SheetFan): the partner comes first
  std::vector<Point3> partner_ring;  // of the partner's: v comes first; none if the partner stays
  std::size_t end = 0, partner_end = 0;  // in the rings: where the line goes on

  const Point3& partner() const { return ring[0]; }
  bool partner_stays() const { return partner_ring.empty(); }
};

// Where a line comes to lie whose vertices meet at a position: the points there that are nearest to
// where the two were.
struct MovedLine {
  Point3 position{};
  Point3 near_v{}, near_partner{};
};
MovedLine move_line(const SheetPair& pair, const Point3& position);
// How far is the one course of the line at most from the other?
double distance_of(const SheetPair& pair, const MovedLine& line);

// Of a line that runs from v to its partner, seen from outside.
enum class LineSide : std::uint8_t { kLeft, kRight };

// All triangles round v, or round both, and the fan at a position.
void collect_disc(const SheetPair& pair, const Point3& position, PatchChange* out);
// Those on one side of a line, whose points on it have gone to its new place, and their part of the
// fan; where the new vertex comes to lie on the edge of the two, the triangle there is cut in two.
void collect_side(const SheetPair& pair, const MovedLine& line, LineSide side, PatchChange* out);
// The same triangles as they were.
void collect_old_side(const SheetPair& pair, LineSide side, std::vector<Triangle3>* out);

}  // namespace tetfusion
