#include "mesh/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "base/resources.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::make_mesh;

Geometry regular() {
  return make_mesh({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 2, 1, 3}});
}

TEST(Quality, RegularTet) {
  const Quality q = measure_quality(regular());
  EXPECT_NEAR(q.mean_ratio.min, 1, 1e-6);
  EXPECT_NEAR(q.mean_ratio.mean, 1, 1e-12);
  EXPECT_NEAR(q.min_dihedral_deg.min, 70.528779, 1e-5);
  EXPECT_DOUBLE_EQ(q.longest_edge, std::sqrt(8.0));
  EXPECT_DOUBLE_EQ(q.max_aspect, 1);
  EXPECT_EQ(q.mean_ratio_bins[17], 1u);
  EXPECT_EQ(q.dihedral_bins[14], 1u);
}

TEST(Quality, CornerOfACube) {
  const Quality q = measure_quality(testing::single_tet());
  // V = 1/6, squared edges 1, 1, 1, 2, 2, 2.
  EXPECT_NEAR(q.mean_ratio.mean, 12 * std::pow(0.5, 2.0 / 3) / 9, 1e-12);
  EXPECT_NEAR(q.min_dihedral_deg.mean, 54.735610, 1e-6);
  EXPECT_DOUBLE_EQ(q.max_aspect, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(q.shortest_edge, 1);
}

// What a dihedral angle says of the mean ratio at best, as the kernel's README proves it.
double best_mean_ratio(double dihedral) {
  const double half = std::sin(dihedral / 2);
  const double share = std::sin(dihedral) / (1 + half * half);
  return std::cbrt(2 * share * share);
}

TEST(Quality, MeanRatiosBoundAngles) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  double nearest = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<Vec3<double>> p(4);
    for (Vec3<double>& v : p) v = {normal(random), normal(random), normal(random)};
    // Every other one is nearly flat, or nearly an edge.
    const double thin = std::pow(10, -4.0 * (i % 5) / 4);
    for (std::size_t k = 2; k < 4; ++k) p[k].z = p[0].z + thin * (p[k].z - p[0].z);
    if (i % 2 == 0) p[3] = {p[2].x + thin * p[3].x, p[2].y + thin * p[3].y, p[2].z + thin * p[3].z};
    const Shape shape = measure_shape(p[0], p[1], p[2], p[3]);
    const double bound = best_mean_ratio(std::acos(shape.min_dihedral_cosine));
    EXPECT_LE(std::abs(shape.mean_ratio), bound * (1 + 1e-6));
    nearest = std::max(nearest, std::abs(shape.mean_ratio) / bound);
  }
  EXPECT_GT(nearest, 0.9);
  const Quality wedge = measure_quality(
      make_mesh({{-0.5, 0, 0}, {0.5, 0, 0}, {0, -0.01, 1}, {0, 0.01, 1}}, {{0, 1, 3, 2}}));
  EXPECT_NEAR(std::abs(wedge.mean_ratio.mean) /
                  best_mean_ratio(wedge.min_dihedral_deg.mean * std::numbers::pi / 180),
              1, 1e-3);
  EXPECT_GT(best_mean_ratio(4.2 * std::numbers::pi / 180), 0.22);
  EXPECT_LT(best_mean_ratio(4.18 * std::numbers::pi / 180), 0.22);
}

TEST(Quality, ScaleDoesNotMatter) {
  const Quality plain = measure_quality(regular());
  for (const double scale : {1e-300, 1e-200, 1e-60, 1e60, 1e100, 1e150, 1e200, 1e307}) {
    Geometry mesh = regular();
    for (auto& p : std::get<Vector<Vec3<double>>>(mesh.points))
      p = {scale * p.x, scale * p.y, scale * p.z};
    const Quality q = measure_quality(mesh);
    EXPECT_NEAR(q.mean_ratio.mean, 1, 1e-12);
    EXPECT_NEAR(q.min_dihedral_deg.mean, 70.528779, 1e-5);
    EXPECT_NEAR(q.longest_edge / scale, plain.longest_edge, 1e-12);
    EXPECT_NEAR(q.shortest_edge / scale, plain.shortest_edge, 1e-12);
    EXPECT_NEAR(q.max_aspect, 1, 1e-12);
  }
}

TEST(Quality, OfCoordinatesWhoseDifferencesAreTooLarge) {
  constexpr double kFar = 1.2e308;
  const Quality q = measure_quality(make_mesh(
      {{kFar, kFar, kFar}, {kFar, -kFar, -kFar}, {-kFar, kFar, -kFar}, {-kFar, -kFar, kFar}},
      {{0, 2, 1, 3}}));
  EXPECT_NEAR(std::abs(q.mean_ratio.mean), 1, 1e-12);
  EXPECT_NEAR(q.max_aspect, 1, 1e-12);
  EXPECT_TRUE(std::isinf(q.longest_edge));  // it is above the largest number
}

TEST(Quality, FlatAndPointLikeCells) {
  const Quality flat =
      measure_quality(make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2, 3}}));
  EXPECT_EQ(flat.mean_ratio.min, 0);
  EXPECT_EQ(flat.min_dihedral_deg.min, 0);
  EXPECT_EQ(flat.mean_ratio_bins[0], 1u);
  const Quality point =
      measure_quality(make_mesh({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2, 3}}));
  EXPECT_EQ(point.mean_ratio.min, 0);
  EXPECT_TRUE(std::isinf(point.max_aspect));
}

TEST(Quality, ACellWoundTheOtherWayHasANegativeRatio) {
  Geometry mesh = regular();
  testing::flip_winding(&mesh.tets[0]);
  EXPECT_NEAR(measure_quality(mesh).mean_ratio.min, -1, 1e-6);
  EXPECT_EQ(measure_quality(mesh).mean_ratio_bins[0], 1u);
}

TEST(Quality, PercentileAndBins) {
  Geometry mesh = regular();
  // 199 regular cells and one that is flat: the second of 200 is at one hundredth.
  mesh.tets.assign(199, mesh.tets[0]);
  mesh.tets.push_back({0, 1, 2, 2});
  Quality q = measure_quality(mesh);
  EXPECT_EQ(q.mean_ratio.min, 0);
  EXPECT_NEAR(q.mean_ratio.p1, 1, 1e-6);
  EXPECT_EQ(q.mean_ratio_bins[0], 1u);
  EXPECT_EQ(q.mean_ratio_bins[17], 199u);
  mesh.tets.insert(mesh.tets.end(), 4, {0, 1, 2, 2});
  q = measure_quality(mesh);
  EXPECT_EQ(q.mean_ratio.p1, 0);
}

TEST(Quality, NoCells) {
  const Quality q = measure_quality(make_mesh({}, {}));
  EXPECT_EQ(q.mean_ratio.mean, 0);
  EXPECT_EQ(q.longest_edge, 0);
}

TEST(Quality, ThreadsChangeNothing) {
  const Geometry mesh = testing::to_float(testing::five_split_cube(31, 0.2));
  set_thread_count(1);
  const Quality one = measure_quality(mesh);
  set_thread_count(4);
  const Quality four = measure_quality(mesh);
  set_thread_count(0);
  EXPECT_EQ(one.mean_ratio.mean, four.mean_ratio.mean);
  EXPECT_EQ(one.mean_ratio.p1, four.mean_ratio.p1);
  EXPECT_EQ(one.min_dihedral_deg.mean, four.min_dihedral_deg.mean);
  EXPECT_EQ(one.dihedral_bins, four.dihedral_bins);
  EXPECT_EQ(std::accumulate(one.dihedral_bins.begin(), one.dihedral_bins.end(), std::uint64_t{0}),
            mesh.tets.size());
}

}  // namespace
}  // namespace tetfusion
