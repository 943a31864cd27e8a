#include "kernel/sheets/facing_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::uniform;

FacingBox around(const Point3& p, double by) {
  FacingBox box{p, p};
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

TEST(FacingGrid, KnowsWhereASurfaceIsAlone) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {64, 64, 64}});
  const FacingBox box = around({10.5, 10.5, 10.5}, 0.2);
  EXPECT_TRUE(grid.looks_one_way(box));
  const auto note = [&](const Point3& normal) {  // at 10.5
    const Point3 axis = std::abs(normal[0]) < 0.7 ? Point3{1, 0, 0} : Point3{0, 1, 0};
    Point3 u = cross(normal, axis), v = cross(normal, u);
    Point3 a{10.5, 10.5, 10.5}, b = a, c = a;
    for (std::size_t i = 0; i < 3; ++i) {
      b[i] += 0.1 * u[i];
      c[i] += 0.1 * v[i];
    }
    grid.note(a, b, c);
  };
  note({0.1, 0.2, 1});
  EXPECT_TRUE(grid.looks_one_way(box));
  note({0.2, -0.1, 1});
  note({-0.2, -0.1, 1});
  EXPECT_TRUE(grid.looks_one_way(box));
  note({-1, -1.1, 1});
  EXPECT_TRUE(grid.looks_one_way(box));
  note({0.1, 0.2, -1});
  EXPECT_FALSE(grid.looks_one_way(box));
  EXPECT_TRUE(grid.looks_one_way(around({20, 20, 20}, 0.2)));
}

// The sides of a narrow slit look at one another, those of a wide one are in other cells.
TEST(FacingGrid, SeesTheOtherSideOfASlit) {
  for (const double width : {0.1, 8.0}) {
    FacingGrid grid;
    grid.reset({{0, 0, 0}, {64, 64, 64}});
    grid.note({5, 5, 5}, {5, 6, 5}, {5, 5, 6});                          // looks along x
    grid.note({5 + width, 5, 5}, {5 + width, 5, 6}, {5 + width, 6, 5});  // back
    EXPECT_EQ(grid.looks_one_way(around({5, 5.3, 5.3}, 0.5)), width > 1);
  }
}

std::multiset<std::size_t> cells_of(const FacingGrid& grid, const Triangle3& triangle) {
  std::multiset<std::size_t> cells;
  grid.visit_triangle(triangle, [&](std::size_t cell) {
    cells.insert(cell);
    return false;
  });
  return cells;
}

TEST(FacingGrid, ATriangleIsInEachCellThatItTouches) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {1, 2, 4}});
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const double size = std::pow(0.5, static_cast<double>(seed % 7));
    const auto draw = [&](std::uint64_t i) { return size * uniform(seed, i); };
    const Triangle3 t{Point3{draw(0), 2 * draw(1), 4 * draw(2)},
                      Point3{draw(3), 2 * draw(4), 4 * draw(5)},
                      Point3{draw(6), 2 * draw(7), 4 * draw(8)}};
    const auto cells = cells_of(grid, t);
    EXPECT_EQ(cells_of(grid, {t[1], t[2], t[0]}), cells);
    EXPECT_EQ(cells_of(grid, {t[2], t[1], t[0]}), cells);
    for (std::uint64_t i = 0; i < 200; ++i) {
      double u = uniform(seed, 20 + 2 * i), v = uniform(seed, 21 + 2 * i);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      Point3 p{};
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = t[0][k] + u * (t[1][k] - t[0][k]) + v * (t[2][k] - t[0][k]);
      }
      grid.visit({p, p}, [&](std::size_t cell) {
        EXPECT_TRUE(cells.contains(cell)) << seed;
        return false;
      });
    }
  }
}

TEST(FacingGrid, ANeedleIsInFewCells) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {1, 1, 1}});
  const Triangle3 needle{{{0, 0, 0}, {0.6, 0.6, 0.9}, {0.6, 0.61, 0.9}}};
  const auto cells = cells_of(grid, needle);
  EXPECT_GE(cells.size(), 60u);
  EXPECT_LT(cells.size(), grid.range_of(box_round(needle[0], needle[1], needle[2])).count() / 20);
  // A small one, or one along an axis, is in all that its box has, once.
  for (const Triangle3& t : {Triangle3{{{0.5, 0.5, 0.5}, {0.51, 0.51, 0.52}, {0.5, 0.51, 0.5}}},
                             Triangle3{{{0, 0, 0}, {0.01, 0, 0.9}, {0, 0.01, 0.9}}}}) {
    const auto some = cells_of(grid, t);
    EXPECT_EQ(some.size(), grid.range_of(box_round(t[0], t[1], t[2])).count());
  }
}

}  // namespace
}  // namespace tetfusion
