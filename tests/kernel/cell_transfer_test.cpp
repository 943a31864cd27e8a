#include "kernel/fields/cell_transfer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "mesh/predicates.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_cube;
using testing::make_column;
using testing::values_of;

TetCorners corners_of(const WorkMesh<double>& mesh, std::size_t t) {
  TetCorners out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = mesh.positions[mesh.tets[t][i]];
  return out;
}

double volume_of(const WorkMesh<double>& mesh, std::size_t t) {
  return determinant(mesh.positions, mesh.tets[t]).value;
}

WorkMesh<double> mesh_with(Geometry geometry, auto&& value_of) {
  WorkMesh<double> mesh = testing::to_work_mesh(std::move(geometry));
  Vector<double> values;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) values.push_back(value_of(t));
  mesh.cell_columns = {make_column(1, values)};
  return mesh;
}

// Each vertex inside by a tenth of the grid's width.
void move_vertices(std::uint64_t seed, WorkMesh<double>* mesh) {
  for (VertexId v = 0; v < mesh->vertex_count(); ++v) {
    if ((mesh->marks[v] & kOnBoundary) != 0) continue;
    Vec3<double>& p = mesh->positions[v];
    const auto by = [&](std::uint64_t axis) {
      return 0.2 * (testing::uniform(seed, 3 * v + axis) - 0.5);
    };
    p = {p.x + by(0), p.y + by(1), p.z + by(2)};
  }
}

// Every tetrahedron against every old one.
double mean_over(const WorkMesh<double>& before, const TetCorners& tet) {
  const auto values = values_of<double>(before.cell_columns[0]);
  const OverlapTet shape(tet);
  double sum = 0, all = 0;
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    const double volume = shape.with(corners_of(before, t)).volume;
    sum += volume * values[t];
    all += volume;
  }
  return sum / all;
}

void expect_transferred(const WorkMesh<double>& before, const WorkMesh<double>& mesh) {
  const auto values = values_of<double>(mesh.cell_columns[0]);
  double integral = 0, old_integral = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    EXPECT_NEAR(values[t], mean_over(before, corners_of(mesh, t)), 1e-12);
    integral += volume_of(mesh, t) * values[t];
  }
  const auto old_values = values_of<double>(before.cell_columns[0]);
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    old_integral += volume_of(before, t) * old_values[t];
  }
  EXPECT_NEAR(integral, old_integral, 1e-12 * old_integral);
}

// Vertices have moved, and nothing has gone.
TEST(CellTransfer, TakesWhatItOverlaps) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    WorkMesh<double> mesh = mesh_with(five_split_cube(4, 0.1, seed),
                                      [&](std::size_t t) { return testing::uniform(seed, t); });
    const WorkMesh<double> before = mesh;
    CellTransfer<double> transfer(mesh);
    move_vertices(seed, &mesh);
    transfer.run(std::array{0u}, &mesh);
    EXPECT_NE(mesh.cell_columns[0].rows, before.cell_columns[0].rows);
    expect_transferred(before, mesh);
  }
}

// After fusions, too, where most of what was there is gone.
TEST(CellTransfer, GoesFarWhereMuchHasGone) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    testing::Steered s = testing::steered(five_split_cube(6, 0.2, seed), testing::smooth);
    Vector<double> values;
    for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
      values.push_back(testing::uniform(seed, t));
    }
    s.mesh.cell_columns = {make_column(1, values)};
    const WorkMesh<double> before = s.mesh;
    FuseLimits limits = testing::limits_of();
    limits.keep_integrals = true;
    FuseRound<double> round;
    round.run(limits, s.fields(), &s.mesh);
    EXPECT_LT(s.mesh.tets.size(), 0.7 * static_cast<double>(before.tets.size()));
    expect_transferred(before, s.mesh);
  }
}

// Two meshes in the same place: neither takes over anything of the other.
TEST(CellTransfer, DoesNotTakeWhatLiesElsewhere) {
  Geometry both = five_split_cube(3, 0.1, 1);
  const auto half = static_cast<VertexId>(point_count(both.points));
  const Geometry other = both;
  auto& points = std::get<Vector<Vec3<double>>>(both.points);
  const auto& more = std::get<Vector<Vec3<double>>>(other.points);
  points.insert(points.end(), more.begin(), more.end());
  for (const Tet& t : other.tets) {
    both.tets.push_back({t[0] + half, t[1] + half, t[2] + half, t[3] + half});
  }
  const std::size_t first = other.tets.size();
  WorkMesh<double> mesh = mesh_with(both, [&](std::size_t t) { return t < first ? 0.1 : 0.7; });
  CellTransfer<double> transfer(mesh);
  move_vertices(2, &mesh);
  transfer.run(std::array{0u}, &mesh);
  const auto values = values_of<double>(mesh.cell_columns[0]);
  for (std::size_t t = 0; t < values.size(); ++t) EXPECT_EQ(values[t], t < first ? 0.1 : 0.7);
}

TEST(CellTransfer, WhatIsNoNumberDoesNotSpread) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  WorkMesh<double> mesh =
      mesh_with(five_split_cube(4, 0.1, 1), [](std::size_t t) { return t % 2 == 0 ? kNaN : 0.0; });
  CellTransfer<double> transfer(mesh);
  move_vertices(3, &mesh);
  transfer.run(std::array{0u}, &mesh);
  const auto values = values_of<double>(mesh.cell_columns[0]);
  for (std::size_t t = 0; t < values.size(); ++t) {
    EXPECT_EQ(std::isnan(values[t]), t % 2 == 0);
    EXPECT_TRUE(t % 2 == 0 || values[t] == 0);
  }
}

}  // namespace
}  // namespace tetfusion
