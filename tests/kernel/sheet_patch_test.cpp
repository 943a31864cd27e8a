#include "kernel/sheets/sheet_patch.h"

#include <gtest/gtest.h>

#include <vector>

namespace tetfusion {
namespace {

// Seen from above.
double area_of(const std::vector<Triangle3>& triangles) {
  double sum = 0;
  for (const Triangle3& t : triangles) {
    const double area = cross(minus(t[1], t[0]), minus(t[2], t[0]))[2] / 2;
    EXPECT_GT(area, 0);
    sum += area;
  }
  return sum;
}

double area_of_fan(const PatchChange& change) {
  std::vector<Triangle3> fan;
  const std::size_t n = change.chain.size();
  for (std::size_t i = 0; i + (change.closed ? 0 : 1) < n; ++i) {
    fan.push_back({change.apex, change.chain[i], change.chain[(i + 1) % n]});
  }
  return area_of(fan);
}

// In a plane; the line runs from west over v and the partner to east.
SheetPair pair_between(const Point3& west, const Point3& east) {
  const Point3 v{}, partner{1, 0, 0}, north{0.5, 1, 0}, south{0.5, -1, 0};
  SheetPair pair;
  pair.ring = {partner, north, {-0.5, 1, 0}, west, {-0.5, -1, 0}, south};
  pair.partner_ring = {v, south, {1.5, -1, 0}, east, {1.5, 1, 0}, north};
  pair.end = pair.partner_end = 3;
  return pair;
}

TEST(SheetPatch, TheFanHasTheOutlineOfTheDisc) {
  SheetPair pair = pair_between({-1, 0, 0}, {2, 0, 0});
  PatchChange change;
  collect_disc(pair, {0.4, 0.1, 0}, &change);
  EXPECT_EQ(change.triangles.size(), 10u);
  EXPECT_TRUE(change.closed);
  EXPECT_NEAR(area_of(change.triangles), 5, 1e-12);
  EXPECT_NEAR(area_of_fan(change), 5, 1e-12);

  pair.partner_ring.clear();
  collect_disc(pair, pair.partner(), &change);
  EXPECT_EQ(change.triangles.size(), 6u);
  EXPECT_FALSE(change.closed);
  EXPECT_NEAR(area_of_fan(change), area_of(change.triangles), 1e-12);
}

TEST(SheetPatch, TheSidesOfALineThatIsStraightStay) {
  for (const double x : {0.0, 0.3, 1.0}) {
    const SheetPair pair = pair_between({-1, 0, 0}, {2, 0, 0});
    const MovedLine line = move_line(pair, {x, 0, 0});
    EXPECT_EQ(distance_of(pair, line), 0);
    for (const LineSide side : {LineSide::kLeft, LineSide::kRight}) {
      PatchChange change;
      std::vector<Triangle3> old;
      collect_side(pair, line, side, &change);
      collect_old_side(pair, side, &old);
      EXPECT_FALSE(change.closed);
      EXPECT_NEAR(area_of(old), 2.5, 1e-12);
      EXPECT_NEAR(area_of(change.triangles), 2.5, 1e-12);
      EXPECT_NEAR(area_of_fan(change), 2.5, 1e-12);
      for (const Triangle3& t : old) {
        for (const Point3& p : t) EXPECT_GE(side == LineSide::kLeft ? p[1] : -p[1], 0);
      }
    }
  }
}

// Its sides take from one another what it goes over.
TEST(SheetPatch, ALineThatIsBentDrawsItsSidesWithIt) {
  SheetPair pair = pair_between({-1, -0.4, 0}, {2, -0.4, 0});
  for (const bool stays : {false, true}) {
    if (stays) pair.partner_ring.clear();
    const Point3 position = stays ? pair.partner() : Point3{0.5, 0, 0};
    const MovedLine line = move_line(pair, position);
    EXPECT_GT(distance_of(pair, line), 0.1);
    EXPECT_LT(distance_of(pair, line), 0.4);
    double before = 0, after = 0;
    for (const LineSide side : {LineSide::kLeft, LineSide::kRight}) {
      PatchChange change;
      std::vector<Triangle3> old;
      collect_side(pair, line, side, &change);
      collect_old_side(pair, side, &old);
      EXPECT_NEAR(area_of_fan(change), area_of(change.triangles), 1e-12);
      EXPECT_EQ(area_of(old) < area_of_fan(change), side == LineSide::kLeft);
      before += area_of(old);
      after += area_of_fan(change);
    }
    EXPECT_NEAR(after, before, 1e-12);
  }
}

}  // namespace
}  // namespace tetfusion
