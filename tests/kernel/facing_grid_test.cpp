#include "kernel/facing_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::uniform;

PointBox around(const Point3& p, double by) {
  PointBox box{p, p};
  box.widen(by);
  return box;
}

TEST(FacingGrid, KnowsWhatLooksBack) {
  FacingGrid grid;
  EXPECT_TRUE(grid.empty());
  grid.reset({{0, 0, 0}, {64, 64, 64}});
  // It looks down.
  grid.note({10.2, 10.2, 30.5}, {10.2, 12.7, 30.5}, {12.7, 10.2, 30.5});
  EXPECT_TRUE(grid.may_face(around({11, 11, 30.2}, 0.1), {0, 0, 1}));
  EXPECT_FALSE(grid.may_face(around({11, 11, 30.2}, 0.1), {0, 0, -1}));
  EXPECT_TRUE(grid.may_face(around({11, 11, 29.5}, 0.6), {0, 0, 1}));
  EXPECT_FALSE(grid.may_face(around({11, 11, 29.5}, 0.4), {0, 0, 1}));
  EXPECT_FALSE(grid.may_face(around({14, 11, 30.2}, 0.1), {0, 0, 1}));
  EXPECT_TRUE(grid.may_face({{-5, -5, -5}, {100, 100, 100}}, {0.6, 0, 0.8}));
}

// What looks against a direction is never missed, and what looks the same way never counts.
TEST(FacingGrid, NeverMissesADirection) {
  FacingGrid grid;
  int across = 0, seen = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    grid.reset({{-1, -1, -1}, {1, 1, 1}});
    const auto draw = [&](std::uint64_t i) { return 2 * uniform(seed, i) - 1; };
    const Point3 a{draw(0), draw(1), draw(2)}, b{draw(3), draw(4), draw(5)},
        c{draw(6), draw(7), draw(8)}, d{draw(9), draw(10), draw(11)};
    grid.note(a, b, c);
    const Point3 normal = cross(minus(b, a), minus(c, a));
    const double cosine = dot(normal, d) / std::sqrt(dot(normal, normal) * dot(d, d));
    const bool faces = grid.may_face({a, a}, d);
    if (cosine < 0) {
      EXPECT_TRUE(faces) << seed;
    }
    if (cosine > 0.82) {
      EXPECT_FALSE(faces) << seed;
    }
    ++across;
    seen += faces ? 1 : 0;
  }
  EXPECT_LT(seen, across);
}

}  // namespace
}  // namespace tetfusion
