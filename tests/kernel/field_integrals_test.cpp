#include "kernel/fields/field_integrals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mesh/predicates.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_cube;
using testing::linear;
using testing::make_column;
using testing::rough;
using testing::smooth;
using testing::Steered;
using testing::steered;
using testing::values_of;

// Six times the integral of each component of a column, and that of its absolute value.
struct Integral {
  double value = 0, absolute = 0;
};

template <class T>
std::vector<Integral> of_points(const WorkMesh<double>& mesh, const Column& column) {
  const auto values = values_of<T>(column);
  std::vector<Integral> out(column.components);
  for (const Tet& t : mesh.tets) {
    const double volume = determinant(mesh.positions, t).value;
    for (std::size_t k = 0; k < out.size(); ++k) {
      for (const VertexId v : t) {
        const double value{values[v * out.size() + k]};
        out[k].value += volume / 4 * value;
        out[k].absolute += volume / 4 * std::abs(value);
      }
    }
  }
  return out;
}

template <class T>
std::vector<Integral> of_cells(const WorkMesh<double>& mesh, const Column& column) {
  const auto values = values_of<T>(column);
  std::vector<Integral> out(column.components);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = determinant(mesh.positions, mesh.tets[t]).value;
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].value += volume * double{values[t * out.size() + k]};
      out[k].absolute += volume * std::abs(double{values[t * out.size() + k]});
    }
  }
  return out;
}

void expect_equal(const std::vector<Integral>& a, const std::vector<Integral>& b, double share) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k].value, b[k].value, share * a[k].absolute) << "component " << k;
  }
}

// Point columns: a steering one, a vector, single precision, a constant, integers. Cell columns:
// two components, single precision, integers.
Steered with_columns(std::uint64_t seed, double (*f)(double, double, double)) {
  Steered s = steered(five_split_cube(8, 0.2, seed), f);
  WorkMesh<double>& mesh = s.mesh;
  Vector<double> steering = mesh.steering, vectors, constant, cells;
  Vector<float> single, single_cells;
  Vector<std::int32_t> numbers, cell_numbers;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    const auto& p = mesh.positions[v];
    vectors.insert(vectors.end(), {rough(p.x, p.y, p.z) - 0.5, linear(p.x, p.y, p.z), -p.z});
    single.push_back(static_cast<float>(100 + smooth(p.y, p.x, p.z)));
    constant.push_back(0.1);
    numbers.push_back(static_cast<std::int32_t>(v));
  }
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    cells.insert(cells.end(), {testing::uniform(seed, t) - 0.3, 0.7});
    single_cells.push_back(static_cast<float>(t % 100));
    cell_numbers.push_back(static_cast<std::int32_t>(t));
  }
  mesh.point_columns = {make_column(1, steering), make_column(3, vectors), make_column(1, single),
                        make_column(1, constant), make_column(1, numbers)};
  mesh.cell_columns = {make_column(2, cells), make_column(1, single_cells),
                       make_column(1, cell_numbers)};
  s.field.column = 0;
  return s;
}

TEST(FieldIntegrals, Stay) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Steered s = with_columns(seed, seed == 2 ? rough : smooth);
    const WorkMesh<double> before = s.mesh;
    FuseLimits limits = testing::limits_of();
    limits.keep_integrals = true;
    FuseRound<double> round;
    FuseStatistics statistics = round.run(limits, s.fields(), &s.mesh);
    EXPECT_GT(statistics.pass.fused, 30u);
    statistics = round.run(limits, s.fields(), &s.mesh);
    const WorkMesh<double>& mesh = s.mesh;
    testing::expect_same_domain(mesh, before);
    testing::expect_whole(mesh);
    for (const std::size_t c : {0, 1, 3}) {
      expect_equal(of_points<double>(before, before.point_columns[c]),
                   of_points<double>(mesh, mesh.point_columns[c]), 1e-12);
    }
    expect_equal(of_points<float>(before, before.point_columns[2]),
                 of_points<float>(mesh, mesh.point_columns[2]), 1e-6);
    expect_equal(of_cells<double>(before, before.cell_columns[0]),
                 of_cells<double>(mesh, mesh.cell_columns[0]), 1e-12);
    expect_equal(of_cells<float>(before, before.cell_columns[1]),
                 of_cells<float>(mesh, mesh.cell_columns[1]), 1e-6);
    for (const double x : values_of<double>(mesh.point_columns[3])) EXPECT_EQ(x, 0.1);
    const auto cells = values_of<double>(mesh.cell_columns[0]);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) EXPECT_EQ(cells[2 * t + 1], 0.7);
    for (const double x : values_of<double>(mesh.point_columns[1])) {
      EXPECT_TRUE(std::isfinite(x));
    }
  }
}

// Regions are no fields: their values are not mixed, whatever it does to their integrals. The zeros
// keep their signs.
TEST(FieldIntegrals, LeaveRegionsAsTheyAre) {
  Steered s = with_columns(2, smooth);
  Vector<float> regions;
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    regions.push_back(t % 2 == 0 ? -0.0F : 1.5F);
  }
  s.mesh.cell_columns[1] = make_column(1, regions);
  const WorkMesh<double> before = s.mesh;
  FuseLimits limits = testing::limits_of();
  limits.keep_integrals = true;
  limits.regions = {1};
  EXPECT_GT(testing::run(limits, &s).pass.fused, 30u);
  // Each tetrahedron that is left has what it had, and its number says which it was.
  const auto numbers = values_of<std::int32_t>(s.mesh.cell_columns[2]);
  const auto after = values_of<float>(s.mesh.cell_columns[1]);
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    const float expected = numbers[t] % 2 == 0 ? -0.0F : 1.5F;
    EXPECT_EQ(std::bit_cast<std::uint32_t>(after[t]), std::bit_cast<std::uint32_t>(expected));
  }
  expect_equal(of_cells<double>(before, before.cell_columns[0]),
               of_cells<double>(s.mesh, s.mesh.cell_columns[0]), 1e-12);
}

// Cells whose values are not finite keep them, and no others get any.
TEST(FieldIntegrals, WhatIsNotFiniteDoesNotSpreadAmongCells) {
  for (const double gap :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Steered s = with_columns(1, smooth);
    Vector<double> values;
    double volume = 0;
    for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
      const bool has_none = t % 200 == 0;
      values.insert(values.end(), {has_none ? gap : testing::uniform(1, t), 0.7});
      volume += has_none ? determinant(s.mesh.positions, s.mesh.tets[t]).value : 0;
    }
    s.mesh.cell_columns[0] = make_column(2, values);
    FuseLimits limits = testing::limits_of();
    limits.keep_integrals = true;
    EXPECT_GT(testing::run(limits, &s).pass.fused, 30u);
    const auto after = values_of<double>(s.mesh.cell_columns[0]);
    double volume_after = 0;
    for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
      EXPECT_EQ(after[2 * t + 1], 0.7);
      if (std::isfinite(after[2 * t])) continue;
      EXPECT_EQ(std::isnan(after[2 * t]), std::isnan(gap));
      volume_after += determinant(s.mesh.positions, s.mesh.tets[t]).value;
    }
    EXPECT_NEAR(volume_after, volume, 1e-12);
  }
}

// Values times volumes may be too large for a number, where the values themselves are none too
// large.
TEST(FieldIntegrals, LargeValuesOfCellsStayFinite) {
  Geometry geometry = five_split_cube(8, 0.2, 1);
  for (auto& p : std::get<Vector<Vec3<double>>>(geometry.points))
    p = {16 * p.x, 16 * p.y, 16 * p.z};
  Steered s = steered(std::move(geometry),
                      [](double x, double y, double z) { return smooth(x / 16, y / 16, z / 16); });
  Vector<double> values;
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    const double value = testing::uniform(1, t);
    values.insert(values.end(), {value, value * 0x1p1022});
  }
  s.mesh.cell_columns = {make_column(2, values)};
  FuseLimits limits = testing::limits_of();
  limits.keep_integrals = true;
  EXPECT_GT(testing::run(limits, &s).pass.fused, 30u);
  const auto after = values_of<double>(s.mesh.cell_columns[0]);
  for (std::size_t i = 0; i < after.size(); i += 2) EXPECT_EQ(after[i + 1], after[i] * 0x1p1022);
}

// Where points have no value there is no integral, and nothing stays for its sake; a value stays
// one of those around.
TEST(FieldIntegrals, ThereIsNoneWherePointsHaveNoValue) {
  Steered s = with_columns(1, smooth);
  FuseLimits limits = testing::limits_of();
  limits.keep_integrals = true;
  Steered with_values = s;
  const std::uint64_t fused = testing::run(limits, &with_values).pass.fused;
  Vector<double> half, none;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const bool has_value = s.mesh.positions[v].x < 0.5;
    half.push_back(has_value ? 1 + testing::uniform(1, v)
                             : std::numeric_limits<double>::quiet_NaN());
    none.push_back(std::numeric_limits<double>::infinity());
  }
  s.mesh.point_columns.push_back(make_column(1, half));
  s.mesh.point_columns.push_back(make_column(1, none));
  const WorkMesh<double> before = s.mesh;
  EXPECT_GT(testing::run(limits, &s).pass.fused, fused * 3 / 4);
  for (const std::size_t c : {0, 1, 3}) {
    expect_equal(of_points<double>(before, before.point_columns[c]),
                 of_points<double>(s.mesh, s.mesh.point_columns[c]), 1e-12);
  }
  const auto after = values_of<double>(s.mesh.point_columns[5]);
  std::size_t numbers = 0;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    if (std::isfinite(after[v])) {
      ++numbers;
      EXPECT_TRUE(after[v] >= 1 && after[v] <= 2);
    }
  }
  EXPECT_GT(numbers, s.mesh.vertex_count() / 8);
  EXPECT_LT(numbers, s.mesh.vertex_count() * 3 / 4);
  for (const double x : values_of<double>(s.mesh.point_columns[6])) EXPECT_TRUE(std::isinf(x));
}

// Without being asked to, it does not.
TEST(FieldIntegrals, ChangeUnlessTheyAreKept) {
  Steered s = with_columns(1, rough);
  const WorkMesh<double> before = s.mesh;
  testing::run(testing::limits_of(), &s);
  const auto a = of_points<double>(before, before.point_columns[1]);
  const auto b = of_points<double>(s.mesh, s.mesh.point_columns[1]);
  EXPECT_GT(std::abs(a[0].value - b[0].value), 1e-6 * a[0].absolute);
}

// No value leaves what there was, and a linear field stays linear: there the integral is no reason
// to stay.
TEST(FieldIntegrals, ValuesStayWithinTheirRange) {
  Steered s = with_columns(4, linear);
  const auto range = [](std::span<const double> x) {
    return std::pair{*std::min_element(x.begin(), x.end()), *std::max_element(x.begin(), x.end())};
  };
  s.mesh.point_columns.erase(s.mesh.point_columns.begin() + 1, s.mesh.point_columns.begin() + 3);
  const auto before = range(values_of<double>(s.mesh.point_columns[0]));
  FuseLimits limits = testing::limits_of();
  limits.keep_integrals = true;
  const FuseStatistics kept = testing::run(limits, &s);
  Steered other = with_columns(4, linear);
  const FuseStatistics free = testing::run(testing::limits_of(), &other);
  EXPECT_GT(kept.pass.fused, free.pass.fused / 2);
  const auto values = values_of<double>(s.mesh.point_columns[0]);
  const auto after = range(values);
  EXPECT_GE(after.first, before.first);
  EXPECT_LE(after.second, before.second);
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const auto& p = s.mesh.positions[v];
    EXPECT_NEAR(values[v], linear(p.x, p.y, p.z), 1e-9);
  }
}

}  // namespace
}  // namespace tetfusion
