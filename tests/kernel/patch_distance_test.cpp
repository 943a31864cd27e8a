#include "kernel/sheets/patch_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/meshes.h"
#include "support/surfaces.h"

namespace tetfusion {
namespace {

using testing::furthest;
using testing::uniform;
using Corners = testing::SurfaceTriangle;

// A fan round a centre, over a ring, that another apex takes over.
PatchChange star(const std::vector<Point3>& ring, const Point3& centre, const Point3& apex) {
  PatchChange change;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    change.triangles.push_back({centre, ring[i], ring[(i + 1) % ring.size()]});
    change.edges.push_back({centre, ring[i]});
  }
  change.points = {centre};
  change.apex = apex;
  change.chain = ring;
  return change;
}

std::vector<Point3> square() { return {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}; }

TEST(PatchDistance, TheTipOfAPyramidGoesDown) {
  const auto down = measure(star(square(), {0, 0, 0.25}, {0, 0, 0}));
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->distance, 0.25, 1e-5);
  EXPECT_NEAR(down->rise, 0, 1e-15);
  EXPECT_NEAR(down->normal[2], 1, 1e-15);
  const auto up = measure(star(square(), {0, 0, 0}, {0, 0, 0.25}));
  ASSERT_TRUE(up);
  EXPECT_NEAR(up->distance, 0.25, 1e-5);
  EXPECT_NEAR(up->rise, 0.25, 1e-15);
}

// The diagonal of a square that is no plane: the other one is twice as far as a corner is off it.
TEST(PatchDistance, EdgesThatCross) {
  PatchChange change;
  const Point3 a{-1, -1, 0.1}, b{1, -1, -0.1}, c{1, 1, 0.1}, d{-1, 1, -0.1};
  change.triangles = {{a, b, c}, {a, c, d}};
  change.edges = {{a, c}};
  change.apex = b;
  change.chain = {c, d, a};
  change.closed = false;
  const auto distance = measure(change);
  ASSERT_TRUE(distance);
  EXPECT_NEAR(distance->distance, 0.2, 1e-5);
  EXPECT_NEAR(distance->rise, 0, 1e-15);
}

TEST(PatchDistance, AFlatPatchDoesNotMove) {
  for (const Point3 apex : {Point3{0.5, 0.25, 0}, Point3{0, 0, 0}, Point3{-0.9, 0.9, 0}}) {
    const auto distance = measure(star(square(), {0.125, 0.25, 0}, apex));
    ASSERT_TRUE(distance);
    EXPECT_EQ(distance->distance, 0);
  }
}

TEST(PatchDistance, RefusesWhatIsNoGraph) {
  // The apex lies outside, or on the outline.
  EXPECT_FALSE(measure(star(square(), {0, 0, 0}, {1.5, 0, 0})));
  EXPECT_FALSE(measure(star(square(), {0, 0, 0}, {1, 0, 0})));
  // Steep.
  EXPECT_TRUE(measure(star(square(), {0, 0, 0}, {0, 0, 1.6})));
  EXPECT_FALSE(measure(star(square(), {0, 0, 0}, {0, 0, 1.8})));
  // Twice round.
  std::vector<Point3> spiral;
  for (int i = 0; i < 14; ++i) {
    const double angle = 4 * std::numbers::pi * i / 14;
    spiral.push_back({std::cos(angle), std::sin(angle), 0.001 * i});
  }
  EXPECT_FALSE(measure(star(spiral, {0, 0, 0}, {0.1, 0, 0})));
  // Round more than once, but open.
  PatchChange open = star(spiral, {0, 0, 0}, {0.1, 0, 0});
  open.closed = false;
  open.chain.resize(9);
  EXPECT_FALSE(measure(open));
  EXPECT_FALSE(measure(PatchChange{}));
}

// The bound holds both ways, and is not far from what is measured.
TEST(PatchDistance, IsABoundBothWays) {
  int measured = 0;
  double worst = 1;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    std::uint64_t draws = 0;
    const auto draw = [&] { return uniform(seed, ++draws) - 0.5; };
    const std::size_t n = 4 + seed % 6;
    std::vector<Point3> ring;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle =
          2 * std::numbers::pi * (static_cast<double>(i) + 0.5 * draw()) / static_cast<double>(n);
      const double r = 1 + 0.8 * draw();
      ring.push_back({r * std::cos(angle), r * std::sin(angle), 0.3 * draw()});
    }
    const Point3 centre{0.3 * draw(), 0.3 * draw(), 0.5 * draw()};
    const Point3 apex{0.3 * draw(), 0.3 * draw(), 0.5 * draw()};
    PatchChange change = star(ring, centre, apex);
    if (seed % 3 == 0) {  // the centre goes to a point of the ring
      change.closed = false;
      change.apex = ring[0];
      change.chain.erase(change.chain.begin());
    }
    const auto distance = measure(change);
    if (!distance) continue;
    ++measured;
    std::vector<Corners> fan;
    const std::size_t m = change.chain.size();
    for (std::size_t i = 0; i + (change.closed ? 0 : 1) < m; ++i) {
      fan.push_back({change.apex, change.chain[i], change.chain[(i + 1) % m]});
    }
    const double truth = std::max(furthest(change.triangles, fan), furthest(fan, change.triangles));
    EXPECT_LE(truth, distance->distance) << seed;
    EXPECT_LE(distance->rise, distance->distance);
    worst = std::min(worst, truth / distance->distance);
  }
  EXPECT_GT(measured, 100);
  EXPECT_GT(worst, 0.25);
}

// Over or under the triangle z = x / 2 between x = 0 and 1.
TEST(LiesOnSide, LooksAtWhatIsSeenOverTheOther) {
  const Corners other{{{0, 0, 0}, {1, 0, 0.5}, {0, 1, 0}}};
  const Point3 up{0, 0, 1};
  const auto sides = [&](const Corners& triangle) {
    return std::pair(lies_on_side(triangle, other, up, Side::kBehind, 1e-6),
                     lies_on_side(triangle, other, up, Side::kBefore, 1e-6));
  };
  const std::pair behind(true, false), before(false, true), neither(false, false), both(true, true);
  EXPECT_EQ(sides({{{0, 0, -0.1}, {1, 0, 0.4}, {0, 1, -0.1}}}), behind);
  EXPECT_EQ(sides({{{0, 0, 0.1}, {1, 0, 0.6}, {0, 1, 0.1}}}), before);
  EXPECT_EQ(sides({{{0.1, 0.1, -1}, {0.5, 0.1, 1}, {0.1, 0.5, 0.5}}}), neither);
  // In its plane.
  EXPECT_EQ(sides({{{0.1, 0.1, 0.05}, {0.5, 0.1, 0.25}, {0.1, 0.5, 0.05}}}), neither);
  // Beside it, whatever its height, and along its side, where a neighbour begins.
  EXPECT_EQ(sides({{{2, 0, -1}, {3, 0, 1}, {2, 1, 1}}}), both);
  EXPECT_EQ(sides({{{0, 0, 0}, {0, 1, 0}, {-1, 0, 3}}}), both);
  // A neighbour that leans over it, or goes back under it.
  EXPECT_EQ(sides({{{0, 0, 0}, {0, 1, 0}, {0.5, 0.2, 3}}}), before);
  EXPECT_EQ(sides({{{0, 0, 0}, {0, 1, 0}, {0.5, 0.2, -3}}}), behind);
  // High above its plane, and through it only where the other one is not.
  EXPECT_EQ(sides({{{0.1, 0.1, 1}, {0.2, 0.1, 1}, {8, 8, -10}}}), before);
}

}  // namespace
}  // namespace tetfusion
