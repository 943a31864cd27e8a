#include "mesh/polygon_cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAreArray;
using Ids = std::vector<VertexId>;
using Positions = std::vector<Vec3<double>>;
using Triangle = std::array<VertexId, 3>;
using Triangles = std::vector<Triangle>;

// Its smallest vertex first, wound as it is.
Triangle from_smallest(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

Triangles cut(const Ids& ids, const Positions& positions) {
  PolygonCut cut;
  Triangles all;
  for (const Triangle& t : cut.cut(ids, positions)) all.push_back(from_smallest(t));
  return all;
}

// Numbered from 0 on.
Triangles cut(const Positions& positions) {
  Ids ids;
  for (VertexId i = 0; i < positions.size(); ++i) ids.push_back(i);
  return cut(ids, positions);
}

// In the plane z = 0, seen from above.
double area(const Triangle& t, const Positions& p) {
  const auto &a = p[t[0]], &b = p[t[1]], &c = p[t[2]];
  return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
}

double whole_area(const Positions& p) {
  double sum = 0;
  for (VertexId i = 2; i < p.size(); ++i) sum += area({0, i - 1, i}, p);
  return sum;
}

double least_area(const Triangles& triangles, const Positions& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles) least = std::min(least, area(t, p));
  return least;
}

void expect_is_cut(const Positions& p, double least) {
  const Triangles triangles = cut(p);
  ASSERT_EQ(triangles.size(), p.size() - 2);
  double sum = 0;
  for (const Triangle& t : triangles) sum += area(t, p);
  EXPECT_NEAR(sum, whole_area(p), 1e-12);
  EXPECT_GE(least_area(triangles, p), least);
}

TEST(PolygonCut, LeavesATriangleAsItIs) {
  EXPECT_THAT(cut({7, 3, 5}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), ElementsAre(Triangle{3, 5, 7}));
}

TEST(PolygonCut, CutsAQuadrilateralFromItsSmallestVertex) {
  const Positions square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_THAT(cut({4, 9, 2, 7}, square),
              UnorderedElementsAreArray(Triangles{{2, 7, 4}, {2, 4, 9}}));
  // Also where the other diagonal gives better triangles.
  const Positions kite{{0, 0, 0}, {3, -1, 0}, {6, 0, 0}, {3, 1, 0}};
  EXPECT_THAT(cut(kite), UnorderedElementsAreArray(Triangles{{0, 1, 2}, {0, 2, 3}}));
}

TEST(PolygonCut, CutsAQuadrilateralWithThreeVerticesInLineByTheOtherDiagonal) {
  EXPECT_THAT(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}),
              UnorderedElementsAreArray(Triangles{{0, 1, 3}, {1, 2, 3}}));
}

TEST(PolygonCut, LetsVerticesHangOnStraightSides) {
  expect_is_cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 0.5);
  expect_is_cut(
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}},
      0.5);
  // Three on one side of a triangle: there is one way.
  expect_is_cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {2, 3, 0}}, 1.5);
}

TEST(PolygonCut, GoesRoundDents) {
  expect_is_cut({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 0.5);
  // A comb.
  expect_is_cut({{0, 0, 0}, {5, 0, 0}, {5, 4, 0}, {4, 1, 0}, {3, 4, 0}, {2, 1, 0}, {1, 4, 0}}, 0.4);
}

TEST(PolygonCut, CutsThinAndBentQuadrilateralsAsOtherCellsDo) {
  const Positions thin{{1, 0, 0}, {1, 1, 0}, {1, 1.2, .0022}, {1, .2, .0022}};
  const Positions dart{{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}};
  for (const Positions& positions : {thin, dart}) {
    for (VertexId first = 0; first < 4; ++first) {
      Ids ids;
      for (VertexId i = 0; i < 4; ++i) ids.push_back((i + first) % 4);
      EXPECT_THAT(cut(ids, positions), UnorderedElementsAreArray(Triangles{{0, 1, 2}, {0, 2, 3}}));
    }
  }
}

TEST(PolygonCut, CountsAVertexThatFollowsItselfOnce) {
  const Positions positions{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_THAT(cut({0, 1, 1, 2}, positions), ElementsAre(Triangle{0, 1, 2}));
  EXPECT_THAT(cut({2, 0, 1, 1}, {{0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}}),
              ElementsAre(Triangle{0, 1, 2}));
  EXPECT_THAT(cut({1, 2, 0, 1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}}),
              ElementsAre(Triangle{0, 1, 2}));
}

TEST(PolygonCut, HasNothingOfWhatIsNone) {
  EXPECT_TRUE(cut({0, 1}, {{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_TRUE(cut({}, {}).empty());
  EXPECT_TRUE(cut({3, 3, 3}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}).empty());
  EXPECT_TRUE(cut({0, 1, 0, 1}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}}).empty());
}

TEST(PolygonCut, TakesCoordinatesThatAreNoNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(cut({{0, 0, 0}, {nan, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}).size(), 3);
  EXPECT_EQ(cut(Positions(6, {1, 1, 1})).size(), 4);
}

TEST(PolygonCut, CutsVeryManyCornersFromTheSmallest) {
  Positions circle;
  for (int i = 0; i < 100; ++i) {
    const double angle = 2 * std::numbers::pi * i / 100;
    circle.push_back({std::cos(angle), std::sin(angle), 0});
  }
  expect_is_cut(circle, 1e-9);
}

// Round a circle, with vertices in the middle of sides, moved off the plane a little.
Positions random_polygon(std::mt19937* random) {
  std::uniform_real_distribution<double> share(0, 1);
  const int corners = 3 + static_cast<int>((*random)() % 6);
  Positions points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.6 * share(*random)) / corners;
    points.push_back({std::cos(angle), std::sin(angle), 0.1 * share(*random)});
  }
  Positions all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<double>&a = points[i], &b = points[(i + 1) % points.size()];
    all.push_back(a);
    if (share(*random) < 0.4) all.push_back({(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2});
  }
  return all;
}

TEST(PolygonCut, IsTheSameWhereverTheListBeginsAndWhicheverWayItGoes) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 2000; ++trial) {
    Positions positions = random_polygon(&random);
    Ids ids(positions.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<VertexId>(3 * i + 1);
    std::shuffle(ids.begin(), ids.end(), random);
    const Triangles expected = cut(ids, positions);
    ASSERT_EQ(expected.size(), ids.size() - 2);
    const auto by = static_cast<std::ptrdiff_t>(random() % ids.size());
    std::rotate(ids.begin(), ids.begin() + by, ids.end());
    std::rotate(positions.begin(), positions.begin() + by, positions.end());
    EXPECT_THAT(cut(ids, positions), UnorderedElementsAreArray(expected));
    std::reverse(ids.begin(), ids.end());
    std::reverse(positions.begin(), positions.end());
    Triangles turned = expected;
    for (Triangle& t : turned) t = from_smallest({t[0], t[2], t[1]});
    EXPECT_THAT(cut(ids, positions), UnorderedElementsAreArray(turned));
  }
}

TEST(PolygonCut, LeavesNothingFlatOfConvexPolygonsWithMiddles) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 2000; ++trial) {
    Positions positions = random_polygon(&random);
    for (auto& p : positions) p.z = 0;
    const double shortest_side = 0.02;
    expect_is_cut(positions, positions.size() == 3 ? 0 : shortest_side * shortest_side / 8);
  }
}

}  // namespace
}  // namespace tetfusion
