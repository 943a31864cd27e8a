#include "kernel/fusions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/greedy_pass.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::make_column;
using testing::values_of;

template <class T>
Vector<T> carried(std::uint32_t components, const Vector<T>& values,
                  const std::vector<Fusion>& fusions = {{{1, 0, 4, 3}, 2}}) {
  Column column = make_column(components, values);
  carry_point_column(fusions, &column);
  const auto out = values_of<T>(column);
  return {out.begin(), out.end()};
}

TEST(CarryPointColumn, FloatsTakeTheMean) {
  EXPECT_EQ(carried<float>(2, {1, 10, 2, 20, 3, 30, 4, 40, 5, 50}),
            (Vector<float>{1, 10, 3, 30, 3, 30, 4, 40, 5, 50}));
}

TEST(CarryPointColumn, IntegersTakeTheNearest) {
  EXPECT_EQ(carried<std::int64_t>(1, {10, 11, 12, 13, 14}),
            (Vector<std::int64_t>{10, 14, 12, 13, 14}));
  EXPECT_EQ(carried<std::uint8_t>(3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14}),
            (Vector<std::uint8_t>{0, 1, 2, 12, 13, 14, 6, 7, 8, 9, 10, 11, 12, 13, 14}));
}

TEST(CarryPointColumn, EachFusionHasItsOwnRow) {
  EXPECT_EQ(
      carried<double>(1, {1, 2, 3, 4, 10, 20, 30, 40, 7}, {{{3, 0, 1, 2}, 0}, {{4, 5, 6, 7}, 0}}),
      (Vector<double>{1, 2, 3, 2.5, 25, 20, 30, 40, 7}));
}

TEST(CarryPointColumn, FiniteValuesCountIfThereAreTwo) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(carried<double>(1, {1, 2, 7, kNan, 6})[1], 3);
  EXPECT_EQ(carried<double>(1, {1, kInfinity, 7, kNan, 6})[1], 3.5);
  EXPECT_TRUE(std::isnan(carried<double>(1, {1, kNan, 7, kNan, kNan})[1]));
  EXPECT_EQ(carried<double>(1, {1, kInfinity, 7, kInfinity, kInfinity})[1], kInfinity);
}

// Of four values.
template <class T>
T interpolated(const std::array<double, 4>& weights, const Vector<T>& values) {
  Column column = make_column(1, values);
  const Interpolation one{0, {0, 1, 2, 3}, weights, 0};
  interpolate_point_column({&one, 1}, &column);
  return values_of<T>(column)[0];
}

TEST(InterpolatePointColumn, FiniteValuesCountIfTheyHaveHalfOfTheWeight) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto at = interpolated<float>;
  EXPECT_EQ(at({0.25, 0.25, 0.25, 0.25}, {1, 2, 3, 4}), 2.5F);
  EXPECT_EQ(at({0.5, 0.25, 0.25, 0}, {kNan, 2, 4, 8}), 3.0F);
  EXPECT_EQ(at({0.25, 0.25, 0.5, 0}, {1, 4, kNan, kNan}), 2.5F);
  EXPECT_EQ(at({0, 1, 0, 0}, {kNan, 4, kNan, kNan}), 4.0F);
  EXPECT_TRUE(std::isnan(at({0.75, 0.25, 0, 0}, {kNan, 4, 5, 6})));
}

TEST(InterpolatePointColumn, TheLargestValuesThatThereAreStayFinite) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const auto at = interpolated<double>;
  EXPECT_EQ(at({0.5, 0.5, 0, 0}, {kMost, -kMost, 1, 1}), 0);
  // By rounding the weights may be more than one together.
  EXPECT_EQ(at({1e-16, 0.5, 0.5, 3e-16}, {-kMost, kMost, kMost, kMost}), kMost);
}

// Passes take the columns along: linear fields stay linear, whatever vertices were fused into what,
// and every vertex and tetrahedron keeps its own rows.
TEST(CarryPointColumn, ALinearFieldStaysLinearOverPasses) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(12, 0.2, 11));
  const auto f = [](const Vec3<double>& p) { return 2 * p.x - 3 * p.y + 0.5 * p.z + 1; };
  Vector<double> pairs;
  for (const auto& p : mesh.positions) pairs.insert(pairs.end(), {f(p), -f(p)});
  mesh.point_columns.push_back(make_column(2, pairs));
  mesh.point_columns.push_back(make_column(1, Vector<VertexId>(mesh.point_ids)));
  testing::number_tets(&mesh);
  Vector<float> doubled;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) doubled.push_back(2 * static_cast<float>(t));
  mesh.cell_columns.push_back(make_column(1, doubled));

  GreedyPass<double> pass;
  PassLimits limits;
  while (pass.run(limits, {}, &mesh).fused > 0) ++limits.number;
  ASSERT_GT(limits.number, 2u);
  const auto carried_pairs = values_of<double>(mesh.point_columns[0]);
  const auto ids = values_of<VertexId>(mesh.point_columns[1]);
  ASSERT_EQ(carried_pairs.size(), 2 * mesh.vertex_count());
  ASSERT_EQ(ids.size(), mesh.vertex_count());
  std::size_t other_row = 0;  // of an integer array: that of another of the four
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(carried_pairs[2 * v], f(mesh.positions[v]), 1e-13);
    EXPECT_NEAR(carried_pairs[2 * v + 1], -f(mesh.positions[v]), 1e-13);
    if (ids[v] != mesh.point_ids[v]) ++other_row;
  }
  EXPECT_GT(other_row, 0u);
  EXPECT_LT(other_row, mesh.vertex_count() / 2);
  const auto numbers = values_of<TetId>(mesh.cell_columns[0]);
  const auto twice = values_of<float>(mesh.cell_columns[1]);
  ASSERT_EQ(numbers.size(), mesh.tets.size());
  EXPECT_TRUE(std::ranges::is_sorted(numbers));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    EXPECT_EQ(twice[t], 2 * static_cast<float>(numbers[t]));
  }
}

}  // namespace
}  // namespace tetfusion
