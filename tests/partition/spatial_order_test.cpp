#include "partition/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/resources.h"

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
  // The curve steps from cell to neighbouring cell, so the mean step is one, give or take the grid's rounding.
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

}  // namespace
}  // namespace tetfusion
