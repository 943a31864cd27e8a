#include "partition/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/resources.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

Vector<Vec3<float>> grid(int side) {
  Vector<Vec3<float>> points;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
      }
    }
  }
  return points;
}

TEST(PointsAlongCurve, IsAPermutationWhoseStepsAreShort) {
  const Vector<Vec3<float>> points = grid(16);
  const Vector<VertexId> order = points_along_curve(Points(points));
  Vector<VertexId> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  double length = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    ASSERT_EQ(sorted[i], i);
    if (i == 0) continue;
    const Vec3<float>&a = points[order[i - 1]], &b = points[order[i]];
    length += std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z);
  }
  // The curve steps from cell to neighbouring cell, so the mean step is one, give or take the
  // grid's rounding.
  EXPECT_LT(length / static_cast<double>(order.size()), 1.2);
}

TEST(PointsAlongCurve, TakesPointsThatAreAllTheSame) {
  const Vector<Vec3<float>> points(5, Vec3<float>{1, 2, 3});
  const Vector<VertexId> order = points_along_curve(Points(points));
  for (VertexId i = 0; i < 5; ++i) EXPECT_EQ(order[i], i);
}

TEST(PointsAlongCurve, TakesTheWholeRangeOfDoubles) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  const Vector<Vec3<double>> points{{kHuge, 0, 0}, {-kHuge, 0, 0}, {0, 0, 0}};
  Vector<VertexId> order = points_along_curve(Points(points));
  std::sort(order.begin(), order.end());
  for (VertexId i = 0; i < 3; ++i) EXPECT_EQ(order[i], i);
}

TEST(PointsAlongCurve, DoesNotDependOnThreads) {
  const Points points = grid(20);
  set_thread_count(1);
  const Vector<VertexId> one = points_along_curve(points);
  set_thread_count(3);
  EXPECT_EQ(points_along_curve(points), one);
  set_thread_count(0);
}

TEST(TetsByFirstVertex, SortsStably) {
  const Vector<Tet> tets{{5, 6, 7, 2}, {9, 8, 0, 4}, {2, 3, 4, 5}, {1, 9, 8, 7}};
  const Vector<TetId> order = tets_by_first_vertex(tets, 10);
  EXPECT_EQ(order, (Vector<TetId>{1, 3, 0, 2}));
}

TEST(OrderAlongCurve, KeepsTheMeshAndKnowsWhereItCameFrom) {
  Geometry before = testing::five_split_cube(4, 0.1);
  before.lower.types = {1, 3};
  before.lower.offsets = {0, 1, 3};
  before.lower.connectivity = {7, 3, 100};
  before.tet_source.assign(before.tets.size(), 0);
  for (std::size_t t = 0; t < before.tets.size(); ++t) before.tet_source[t] = 1000 + t;
  Geometry after = before;
  order_along_curve(&after);

  ASSERT_EQ(after.tets.size(), before.tets.size());
  ASSERT_EQ(point_count(after.points), point_count(before.points));
  const auto at = [](const Geometry& g, VertexId v) {
    const auto p = testing::point(g, v);
    return std::array<double, 3>{p.x, p.y, p.z};
  };
  for (VertexId v = 0; v < point_count(after.points); ++v) {
    EXPECT_EQ(at(after, v), at(before, static_cast<VertexId>(after.point_source[v])));
  }
  VertexId last = 0;
  for (std::size_t t = 0; t < after.tets.size(); ++t) {
    const Tet& old = before.tets[after.tet_source[t] - 1000];
    for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(at(after, after.tets[t][c]), at(before, old[c]));
    const VertexId first = *std::min_element(after.tets[t].begin(), after.tets[t].end());
    EXPECT_GE(first, last);
    last = first;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(at(after, after.lower.connectivity[i]), at(before, before.lower.connectivity[i]));
  }
}

}  // namespace
}  // namespace tetfusion
