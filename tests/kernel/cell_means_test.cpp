#include "kernel/fit/cell_means.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Cells of the original with values of one array, and labels.
struct Cells {
  Vector<Vec3<double>> centres;
  Vector<double> volumes;
  Vector<std::uint64_t> hashes;
  Vector<double> values;
  Vector<std::int32_t> labels;

  void add(const Vec3<double>& centre, double volume, double value, std::int32_t label = 0,
           std::uint64_t hash = 1) {
    centres.push_back(centre);
    volumes.push_back(volume);
    hashes.push_back(hash);
    values.push_back(value);
    labels.push_back(label);
  }
};

// Twenty tetrahedra round vertex 0, with the values 0, 1, 2, ...
WorkMesh<double> ball() {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::icosahedron_ball());
  Vector<double> values(mesh.tets.size());
  for (std::size_t t = 0; t < values.size(); ++t) values[t] = static_cast<double>(t);
  mesh.cell_columns = {testing::make_column(1, values)};
  return mesh;
}

template <class T>
Vector<T> rows_of(const Column& column) {
  const std::span<const T> values = testing::values_of<T>(column);
  return {values.begin(), values.end()};
}

// In the tetrahedron, so far from its centre towards a corner.
Vec3<double> place_in(const WorkMesh<double>& mesh, TetId tet, std::size_t corner, double part) {
  const Vec3<double> c = centre_of(mesh.positions, mesh.tets[tet]);
  const Vec3<double>& p = mesh.positions[mesh.tets[tet][corner]];
  return {c.x + part * (p.x - c.x), c.y + part * (p.y - c.y), c.z + part * (p.z - c.z)};
}

Vector<double> average(const Cells& cells, WorkMesh<double> mesh, std::uint64_t first = 0,
                       std::uint64_t step = 1) {
  TetWalk<double> walk;
  walk.begin(mesh);
  CellMeans<double> tool;
  const std::uint32_t column = 0, label = 1;
  const bool has_labels = mesh.cell_columns.size() > 1;
  tool.begin(&mesh, {&column, 1}, {&label, has_labels ? 1u : 0u}, &walk);
  tool.add({cells.centres,
            cells.volumes,
            cells.hashes,
            {reinterpret_cast<const std::byte*>(cells.labels.data())}},
           first, step);
  tool.average([&](std::size_t c, const auto& use) {
    EXPECT_EQ(c, 0u);
    use(cells.volumes.data(), reinterpret_cast<const std::byte*>(cells.values.data()));
  });
  return rows_of<double>(mesh.cell_columns[0]);
}

TEST(CellMeans, CountByVolume) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), 1, 10);
  cells.add(place_in(mesh, 7, 1, 0.2), 2, -5);
  cells.add(place_in(mesh, 3, 2, 0.2), 3, 30);
  cells.add({5, 5, 5}, 3, 1000);  // outside
  Vector<double> expected = rows_of<double>(mesh.cell_columns[0]);
  expected[3] = 25;
  expected[7] = -5;
  EXPECT_EQ(average(cells, mesh), expected);
}

TEST(CellMeans, SmallOnesAloneDoNotCount) {
  const WorkMesh<double> mesh = ball();
  const double volume = volume_of(mesh.positions, mesh.tets[3]);
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), volume / 10, 10);
  EXPECT_EQ(average(cells, mesh)[3], 3);
  cells.volumes[0] = volume / 7;
  EXPECT_EQ(average(cells, mesh)[3], 10);
  // It stands for others that are not looked at.
  cells.volumes[0] = volume / 10;
  EXPECT_EQ(average(cells, mesh, 0, 2)[3], 10);
}

TEST(CellMeans, OneThatIsThereItselfKeepsItsValue) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), 1, 10);
  const Tet& tet = mesh.tets[3];
  // In another order of the corners.
  const Tet other_order{tet[1], tet[3], tet[0], tet[2]};
  cells.add(centre_of(mesh.positions, other_order), volume_of(mesh.positions, other_order), 20, 0,
            corners_hash(mesh.positions, other_order));
  EXPECT_EQ(average(cells, mesh)[3], 3);
  // One with the same centre and the same volume, but other corners, is another one.
  ++cells.hashes.back();
  EXPECT_NE(average(cells, mesh)[3], 3);
}

TEST(CellMeans, WhatIsNoNumberStaysAndDoesNotSpread) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), 1, kNone);
  cells.add(place_in(mesh, 3, 1, 0.2), 1, 10);
  cells.add(place_in(mesh, 3, 2, 0.2), 2, 40);
  cells.add(place_in(mesh, 4, 2, 0.2), 1, kNone);
  cells.add(place_in(mesh, 5, 0, 0.2), 1, 10);
  cells.add(place_in(mesh, 5, 1, 0.2), 2, std::numeric_limits<double>::infinity());
  const Vector<double> values = average(cells, mesh);
  EXPECT_EQ(values[3], 30);
  EXPECT_TRUE(std::isnan(values[4]));  // most of the volume is
  EXPECT_EQ(values[5], std::numeric_limits<double>::infinity());
}

// Equal values stay, to the bit; the largest numbers have a mean that is one, or none.
TEST(CellMeans, StayWithinTheirRange) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  constexpr double kLargest = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < 3; ++k) {
    const double volume = 1.1 * static_cast<double>(k + 1);
    cells.add(place_in(mesh, 3, k, 0.2), volume, 0.1);
    cells.add(place_in(mesh, 4, k, 0.2), volume, kLargest);
    cells.add(place_in(mesh, 5, k, 0.2), volume, k == 1 ? -kLargest : kLargest);
  }
  const Vector<double> values = average(cells, mesh);
  EXPECT_EQ(values[3], 0.1);
  EXPECT_EQ(values[4], kLargest);
  EXPECT_TRUE(std::isfinite(values[5]));
}

// What is added up must neither be infinite nor round to nothing.
TEST(CellMeans, OfLargeAndSmallValuesAndVolumes) {
  const WorkMesh<double> mesh = ball();
  for (const auto& [volume, value] : {std::pair(1e200, 1e308), {1e-200, 1e-200}, {1.0, 1e308}}) {
    Cells cells;
    cells.add(place_in(mesh, 3, 0, 0.2), 3 * volume, value);
    cells.add(place_in(mesh, 3, 1, 0.2), volume, -value);
    if (volume < 1) {  // a cell that has room for them
      WorkMesh<double> small = mesh;
      for (auto& p : small.positions) p = {1e-67 * p.x, 1e-67 * p.y, 1e-67 * p.z};
      for (auto& c : cells.centres) c = {1e-67 * c.x, 1e-67 * c.y, 1e-67 * c.z};
      EXPECT_NEAR(average(cells, small)[3] / value, 0.5, 1e-15);
    } else {
      EXPECT_NEAR(average(cells, mesh)[3] / value, 0.5, 1e-15);
    }
  }
}

TEST(CellMeans, CellsWithOtherLabelsDoNotCount) {
  WorkMesh<double> mesh = ball();
  Vector<std::int32_t> labels(mesh.tets.size(), 1);
  labels[4] = 2;
  mesh.cell_columns.push_back(testing::make_column(1, labels));
  Cells cells;
  for (const TetId tet : {3u, 4u, 5u}) {
    cells.add(place_in(mesh, tet, 0, 0.2), 1, 10, 1);
    cells.add(place_in(mesh, tet, 1, 0.2), 1, 20, 2);
  }
  const Vector<double> values = average(cells, mesh);
  EXPECT_EQ(values[3], 10);
  EXPECT_EQ(values[4], 20);
  EXPECT_EQ(values[5], 10);
}

// As elsewhere: -0 is 0, and what is no number is one region.
TEST(CellMeans, LabelsMayBeOfFloatingPointNumbers) {
  WorkMesh<double> mesh = ball();
  Vector<double> labels(mesh.tets.size(), 0);
  labels[4] = kNone;
  mesh.cell_columns.push_back(testing::make_column(1, labels));
  const Vector<Vec3<double>> centres{place_in(mesh, 3, 0, 0.2), place_in(mesh, 4, 0, 0.2)};
  const Vector<double> volumes{1, 1}, values{10, 20}, of_cells{-0.0, -kNone};
  TetWalk<double> walk;
  walk.begin(mesh);
  CellMeans<double> tool;
  const std::uint32_t column = 0, label = 1;
  tool.begin(&mesh, {&column, 1}, {&label, 1}, &walk);
  const Vector<std::uint64_t> hashes{1, 2};
  tool.add({centres, volumes, hashes, {reinterpret_cast<const std::byte*>(of_cells.data())}}, 0, 1);
  tool.average([&](std::size_t, const auto& use) {
    use(volumes.data(), reinterpret_cast<const std::byte*>(values.data()));
  });
  EXPECT_EQ(rows_of<double>(mesh.cell_columns[0])[3], 10);
  EXPECT_EQ(rows_of<double>(mesh.cell_columns[0])[4], 20);
}

TEST(CellMeans, TakeEveryNthCell) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  for (std::size_t i = 0; i < 7; ++i) {
    cells.add(place_in(mesh, 3, i % 4, 0.2), 1, static_cast<double>(i * i));
  }
  EXPECT_EQ(average(cells, mesh, 2, 3)[3], (4 + 25) / 2.0);
}

// Wound the other way it has no volume to fill.
TEST(CellMeans, OneWithoutVolumeKeepsItsValue) {
  WorkMesh<double> mesh = ball();
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), 1, 10);
  std::swap(mesh.tets[3][0], mesh.tets[3][1]);
  EXPECT_EQ(average(cells, mesh)[3], 3);
}

// Even if it is not looked at.
TEST(CellMeans, OneThatIsThereItselfIsFoundAmongAll) {
  const WorkMesh<double> mesh = ball();
  Cells cells;
  cells.add(place_in(mesh, 3, 0, 0.2), 1, 10);
  const Tet& tet = mesh.tets[3];
  cells.add(centre_of(mesh.positions, tet), 1, 20, 0, corners_hash(mesh.positions, tet));
  EXPECT_EQ(average(cells, mesh, 0, 2)[3], 3);
}

TEST(CellMeans, OneIsKeptOnDemand) {
  WorkMesh<double> mesh = ball();
  const Vector<Vec3<double>> centres{place_in(mesh, 3, 0, 0.2), place_in(mesh, 4, 0, 0.2)};
  const Vector<double> volumes{1, 1}, values{10, 20};
  const Vector<std::uint64_t> hashes{1, 2};
  TetWalk<double> walk;
  walk.begin(mesh);
  CellMeans<double> tool;
  const std::uint32_t column = 0;
  tool.begin(&mesh, {&column, 1}, {}, &walk);
  tool.keep(3);
  tool.add({centres, volumes, hashes, {}}, 0, 1);
  tool.average([&](std::size_t, const auto& use) {
    use(volumes.data(), reinterpret_cast<const std::byte*>(values.data()));
  });
  EXPECT_EQ(rows_of<double>(mesh.cell_columns[0])[3], 3);
  EXPECT_EQ(rows_of<double>(mesh.cell_columns[0])[4], 20);
}

// In two pieces, of columns of several components and of single precision.
TEST(CellMeans, OfEachComponentOfEachColumn) {
  WorkMesh<float> mesh = testing::to_float_work_mesh(testing::icosahedron_ball());
  const std::size_t count = mesh.tets.size();
  mesh.cell_columns = {testing::make_column(2, Vector<double>(2 * count, 0.5)),
                       testing::make_column(1, Vector<std::int32_t>(count, 7)),
                       testing::make_column(1, Vector<float>(count, 0.25F))};
  const WorkMesh<double> same = ball();
  const Vector<Vec3<double>> centres{place_in(same, 3, 0, 0.2), place_in(same, 3, 1, 0.2)};
  const Vector<double> volumes{1, 3}, pairs{1, 2, 5, 6};
  const Vector<float> singles{1, 9};
  TetWalk<float> walk;
  walk.begin(mesh);
  CellMeans<float> tool;
  const std::uint32_t columns[] = {0, 2};
  tool.begin(&mesh, columns, {}, &walk);
  const std::span<const Vec3<double>> all = centres;
  const std::span<const double> weights = volumes;
  const Vector<std::uint64_t> hash{1};
  tool.add({all.first(1), weights.first(1), hash, {}}, 0, 1);
  tool.add({all.subspan(1), weights.subspan(1), hash, {}}, 0, 1);
  tool.average([&](std::size_t column, const auto& use) {
    const auto* const rows = column == 0 ? reinterpret_cast<const std::byte*>(pairs.data())
                                         : reinterpret_cast<const std::byte*>(singles.data());
    use(volumes.data(), rows);
    use(volumes.data() + 1, rows + (column == 0 ? 2 * sizeof(double) : sizeof(float)));
  });
  Vector<double> expected(2 * count, 0.5);
  expected[6] = 4;
  expected[7] = 5;
  EXPECT_EQ(rows_of<double>(mesh.cell_columns[0]), expected);
  EXPECT_EQ(rows_of<std::int32_t>(mesh.cell_columns[1]), Vector<std::int32_t>(count, 7));
  EXPECT_EQ(testing::values_of<float>(mesh.cell_columns[2])[3], 7);
}

}  // namespace
}  // namespace tetfusion
