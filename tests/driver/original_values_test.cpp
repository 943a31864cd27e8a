// The values of new points, fitted to the original's at the end of a run.
#include "driver/rounds/original_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/error.h"
#include "compare/compare.h"
#include "driver/checkpoint.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/comparison.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::array_of;
using testing::bytes_of;
using testing::five_split_cube;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::point_array;
using testing::TempDir;

using P = Vec3<double>;

MeshFile box_with_front(std::uint32_t n) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  file.point_arrays.push_back(point_array<float>(
      file, "wave", [&](const P& p) { return std::tanh(p.x + 0.3 * p.y - 0.6 * n); }));
  return file;
}

// A cell array of the wave, another of a number for each region, and one of whole numbers.
MeshFile box_with_cells(std::uint32_t n) {
  MeshFile file = box_with_front(n);
  const auto& points = std::get<Vector<P>>(file.geometry.points);
  const auto middle = [&](std::size_t t) {
    double x = 0;
    for (const VertexId v : file.geometry.tets[t]) x += points[v].x / 4;
    return x;
  };
  const auto add = [&](const char* name, auto value) {
    file.cell_arrays.push_back(testing::make_array<double>(
        name, file.cells(), 1, [&](std::size_t t, std::size_t) { return value(middle(t)); }));
  };
  add("strain", [](double x) { return std::sin(0.5 * x); });
  add("side", [&](double x) { return x < 0.5 * n ? -3.25 : 7.5; });
  add("material", [&](double x) { return x < 0.5 * n ? 1 : 2; });
  return file;
}

class FittedValuesOf : public ::testing::Test {
 protected:
  void run(bool fit_values) {
    request.behaviour.fit_values = fit_values;
    report = simplify(request);
  }
  ArrayComparison compare(const std::string& output, const std::string& array = "wave") const {
    const auto original = open_mesh(request.input), simplified = open_mesh(output);
    return array_of(compare_meshes(original.get(), simplified.get(), {}), array);
  }
  // Are the bytes the same with and without?
  bool does_nothing() {
    run(true);
    const std::string bytes = bytes_of(request.output);
    run(false);
    return bytes_of(request.output) == bytes;
  }
  FittedValuesOf() {
    request.behaviour.reduction = 0.7;
    box_with_front(16).write(request.input);
  }
  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
  SimplifyReport report;
};

TEST_F(FittedValuesOf, ARunAreNearerToTheOriginals) {
  for (const std::uint64_t chunk_tets : {200'000, 3000}) {
    request.behaviour.chunk_tets = chunk_tets;
    run(false);
    const ArrayComparison before = compare(request.output);
    const auto kept = open_mesh(request.output);
    const Geometry geometry = kept->read_geometry();
    const DataArray values = testing::read_point_array(kept.get(), "wave");
    run(true);
    const ArrayComparison after = compare(request.output);
    EXPECT_LT(after.rms, 0.9 * before.rms);
    if (chunk_tets == 200'000) {
      EXPECT_LT(after.max, before.max);
    }
    const auto fitted = open_mesh(request.output);
    const Geometry same = fitted->read_geometry();
    EXPECT_EQ(same.tets, geometry.tets);
    // Points inside have moved, too.
    std::size_t moved = 0;
    for (VertexId v = 0; v < point_count(geometry.points); ++v) {
      const P p = testing::point(geometry, v), q = testing::point(same, v);
      const std::array was{p.x, p.y, p.z}, now{q.x, q.y, q.z};
      if (was == now) continue;
      ++moved;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NE(was[axis], 0);
        EXPECT_NE(was[axis], 16);
        EXPECT_LT(std::abs(now[axis] - was[axis]), 1);
      }
    }
    EXPECT_GT(moved, point_count(geometry.points) / 50);
    EXPECT_LT(moved, point_count(geometry.points) / 2);
    EXPECT_NE(testing::read_point_array(fitted.get(), "wave").bytes, values.bytes);
    EXPECT_GT(report.seconds.at("fit"), 0);
  }
}

// Those were interpolated again and again.
TEST_F(FittedValuesOf, ArraysThatDoNotSteerAreNearerToo) {
  MeshFile file = box_with_front(16);
  const auto bend = [](double x) { return std::sin(0.5 * x); };
  file.point_arrays.push_back(
      point_array<double>(file, "follows", [&](const P& p) { return bend(p.y) * bend(p.z); }));
  file.point_arrays.push_back(point_array<float>(
      file, "linear", [](const P& p) { return static_cast<float>(3 * p.x - p.y); }));
  file.write(request.input);
  request.behaviour.arrays = {"wave"};
  const auto expect_nearer = [&] {
    run(false);
    const ArrayComparison before = compare(request.output, "follows");
    run(true);
    const ArrayComparison after = compare(request.output, "follows");
    EXPECT_LT(after.rms, 0.95 * before.rms);
    EXPECT_LT(compare(request.output, "linear").max, 1e-6);
  };
  expect_nearer();
  request.behaviour.chunk_tets = 3000;
  expect_nearer();
  request.behaviour.chunk_tets = 200'000;
  // With a bound those that steer are as promised, and the others are fitted.
  request.behaviour.max_error = 0.02;
  expect_nearer();
  const ArrayComparison fitted = compare(request.output);
  EXPECT_LE(fitted.max, 0.02);
  run(false);
  EXPECT_EQ(compare(request.output).rms, fitted.rms);
}

TEST_F(FittedValuesOf, PointsThatStayedAreTheirs) {
  request.behaviour.original_ids = true;
  run(true);
  const auto original = open_mesh(request.input), result = open_mesh(request.output);
  const DataArray before = testing::read_point_array(original.get(), "wave");
  const DataArray after = testing::read_point_array(result.get(), "wave");
  const DataArray ids = testing::read_point_array(result.get(), kOriginalIds);
  std::size_t stayed = 0;
  for (std::size_t i = 0; i < after.info.tuples; ++i) {
    const auto id = ids.as<std::int64_t>()[i];
    if (id < 0) continue;
    ++stayed;
    EXPECT_EQ(after.as<float>()[i], before.as<float>()[id]);
  }
  EXPECT_GT(stayed, 100u);
  EXPECT_LT(stayed, after.info.tuples);
}

TEST_F(FittedValuesOf, LevelsDoNotReachTheNextOne) {
  request.behaviour.reduction.reset();
  request.behaviour.lods = {0.5, 0.7};
  request.output = folder.file("out_{lod}.vtu");
  run(true);
  const ArrayComparison first = compare(report.outputs[0].path),
                        second = compare(report.outputs[1].path);
  const Geometry geometry = open_mesh(report.outputs[1].path)->read_geometry();
  run(false);
  EXPECT_LT(first.rms, compare(report.outputs[0].path).rms);
  EXPECT_LT(second.rms, compare(report.outputs[1].path).rms);
  EXPECT_EQ(open_mesh(report.outputs[1].path)->read_geometry().tets, geometry.tets);
}

TEST_F(FittedValuesOf, ABoundaryThatMovesAreNearerToo) {
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.01;
  run(false);
  const ArrayComparison before = compare(request.output);
  run(true);
  EXPECT_LT(compare(request.output).rms, 0.95 * before.rms);
}

// A cube in two halves so far from each other, with 1000 more on one side than on the other. Where
// they face each other one is as rough as the other is.
MeshFile two_halves(double gap, double roughness) {
  MeshFile file;
  file.geometry = five_split_cube(14, 0, 4);
  auto& points = std::get<Vector<P>>(file.geometry.points);
  std::map<VertexId, VertexId> twins;
  std::vector<bool> right(points.size());
  for (Tet& tet : file.geometry.tets) {
    double above = 0;
    for (const VertexId v : tet) above = std::max(above, points[v].x);
    if (above <= 7) continue;
    for (VertexId& v : tet) {
      if (points[v].x == 7) {
        const auto [twin, is_new] = twins.try_emplace(v, static_cast<VertexId>(points.size()));
        if (is_new) points.push_back(P(points[v]));
        v = twin->second;
      }
      right.resize(points.size());
      right[v] = true;
    }
  }
  for (VertexId v = 0; v < points.size(); ++v) points[v].x += right[v] ? gap : 0;
  for (const auto& [v, twin] : twins) {
    const double bump = roughness * (testing::uniform(5, v) - 0.5);
    points[v].x += bump;
    points[twin].x += bump;
  }
  file.point_arrays.push_back(
      testing::make_array<float>("wave", points.size(), 1, [&](std::size_t v, std::size_t) {
        return (right[v] ? 1000 : 0) + std::sin(0.2 * points[v].y);
      }));
  return file;
}

// Else the value on one side of a crack, or of a gap, would be drawn towards that on the other.
TEST_F(FittedValuesOf, ACrackStayOnTheirSides) {
  const auto expect_sides = [&] {
    run(true);
    const auto result = open_mesh(request.output);
    const Geometry mesh = result->read_geometry();
    const DataArray wave = testing::read_point_array(result.get(), "wave");
    for (const Tet& tet : mesh.tets) {
      const double side = wave.as<float>()[tet[0]] > 500 ? 1000 : 0;
      for (const VertexId v : tet) {
        EXPECT_LT(std::abs(wave.as<float>()[v] - side), 1.01);
      }
    }
  };
  two_halves(0, 0).write(request.input);
  for (const Boundary boundary : {Boundary::kExact, Boundary::kPlanar, Boundary::kWithin}) {
    request.behaviour.boundary = boundary;
    request.behaviour.boundary_distance = boundary == Boundary::kWithin ? 0.02 : 0;
    request.behaviour.chunk_tets = boundary == Boundary::kWithin ? 1000 : 200'000;
    expect_sides();
  }
  // Where the two are smoothed, points of each come to lie in the other.
  two_halves(0.02, 0.3).write(request.input);
  request.behaviour.chunk_tets = 200'000;
  request.behaviour.reduction = 0.97;
  expect_sides();
  EXPECT_GT(report.rounds.back().deviation, 0.001);
}

TEST_F(FittedValuesOf, APromiseAreNotTouched) {
  request.behaviour.max_error = 0.05;
  EXPECT_TRUE(does_nothing());
  request.behaviour.max_error.reset();
  box_with_cells(16).write(request.input);
  EXPECT_FALSE(does_nothing());
  request.behaviour.conserve = true;
  EXPECT_TRUE(does_nothing());
  request.behaviour.conserve = false;
  request.progressive = folder.file("out.tfp");
  EXPECT_TRUE(does_nothing());
  request.progressive.clear();
  request.behaviour.method = Method::kTetFuse;
  request.behaviour.reduction = 0.2;
  EXPECT_TRUE(does_nothing());
}

// Else they would have those of some cell of the original, not even in the middle of them.
TEST_F(FittedValuesOf, CellsAreMeans) {
  box_with_cells(16).write(request.input);
  for (const std::uint64_t chunk_tets : {200'000, 3000}) {
    request.behaviour.chunk_tets = chunk_tets;
    run(false);
    const ArrayComparison before = compare(request.output, "strain");
    const auto read = [&](const char* name) {
      return testing::read_cell_array(open_mesh(request.output).get(), name).bytes;
    };
    const auto material = read("material");
    run(true);
    const ArrayComparison after = compare(request.output, "strain");
    EXPECT_LT(after.rms, 0.8 * before.rms);
    EXPECT_EQ(read("material"), material);  // may be a label
  }
}

TEST_F(FittedValuesOf, CellsOfOtherRegionsDoNotCount) {
  MeshFile file = box_with_cells(16);
  // So rough between them that centres come to lie on the other side where that is smoothed.
  auto& points = std::get<Vector<P>>(file.geometry.points);
  for (VertexId v = 0; v < points.size(); ++v) {
    if (std::abs(points[v].x - 8) < 0.3) points[v].x = 8 + 1.6 * (testing::uniform(5, v) - 0.5);
  }
  file.write(request.input);
  request.behaviour.regions = {{"material"}};
  const auto expect_sides = [&] {
    run(true);
    const auto result = open_mesh(request.output);
    const auto side = testing::cell_values<double>(result.get(), "side");
    const auto material = testing::cell_values<double>(result.get(), "material");
    for (std::size_t t = 0; t < side.size(); ++t) {
      EXPECT_EQ(side[t], material[t] == 1 ? -3.25 : 7.5);
    }
  };
  expect_sides();
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.04;
  request.behaviour.reduction = 0.98;
  expect_sides();
  EXPECT_GT(report.rounds.back().deviation, 0.01);
}

using Corners = std::array<std::array<double, 3>, 4>;

Corners corners_of(const Geometry& mesh, const Tet& tet) {
  Corners all;
  for (std::size_t i = 0; i < 4; ++i) {
    const P p = testing::point(mesh, tet[i]);
    all[i] = {p.x, p.y, p.z};
  }
  std::ranges::sort(all);
  return all;
}

// A second one over the first, which does not fit it anywhere.
void double_with_an_offset(MeshFile* file) {
  auto& points = std::get<Vector<P>>(file->geometry.points);
  const std::size_t count = points.size(), tets = file->geometry.tets.size();
  for (std::size_t v = 0; v < count; ++v) {
    const P p = points[v];
    points.push_back({p.x + 0.41, p.y + 0.37, p.z + 0.29});
  }
  for (std::size_t t = 0; t < tets; ++t) {
    Tet tet = file->geometry.tets[t];
    for (VertexId& v : tet) v += static_cast<VertexId>(count);
    file->geometry.tets.push_back(tet);
  }
}

TEST_F(FittedValuesOf, CellsThatAreAsTheyWereKeepTheirs) {
  for (const bool overlaps_itself : {false, true}) {
    MeshFile file;
    file.geometry = five_split_cube(10, 0.15, 4);
    if (overlaps_itself) double_with_an_offset(&file);
    file.point_arrays.push_back(point_array<float>(
        file, "wave", [&](const P& p) { return std::tanh(p.x + 0.3 * p.y - 6); }));
    file.cell_arrays.push_back(testing::make_array<double>(
        "number", file.cells(), 1,
        [](std::size_t t, std::size_t) { return static_cast<double>(t) + 0.5; }));
    file.write(request.input);
    std::map<Corners, double> old;
    for (std::size_t t = 0; t < file.cells(); ++t) {
      old[corners_of(file.geometry, file.geometry.tets[t])] = static_cast<double>(t) + 0.5;
    }
    for (const std::uint64_t chunk_tets : {200'000, 100}) {
      request.behaviour.chunk_tets = chunk_tets;
      request.behaviour.reduction = 0.3;
      run(true);
      const auto result = open_mesh(request.output);
      const Geometry left = result->read_geometry();
      const auto numbers = testing::cell_values<double>(result.get(), "number");
      std::size_t kept = 0, means = 0;
      for (std::size_t t = 0; t < left.tets.size(); ++t) {
        const auto found = old.find(corners_of(left, left.tets[t]));
        if (found == old.end()) {
          means += numbers[t] != std::floor(numbers[t]) + 0.5 ? 1 : 0;
        } else {
          ++kept;
          EXPECT_EQ(numbers[t], found->second);
        }
      }
      EXPECT_GT(kept, 100u);
      // Where all of it overlaps and one chunk has it, none can be told from others.
      if (!overlaps_itself) {
        EXPECT_GT(means, 100u);
      }
    }
  }
}

TEST_F(FittedValuesOf, IntegersStay) {
  MeshFile file = box_with_front(12);
  file.point_arrays.push_back(point_array<std::int32_t>(
      file, "count", [](const P& p) { return static_cast<int>(10 * p.x); }));
  file.write(request.input);
  request.behaviour.arrays = {"count"};
  const auto count = [&](bool fit_values) {
    run(fit_values);
    return testing::read_point_array(open_mesh(request.output).get(), "count").bytes;
  };
  EXPECT_EQ(count(true), count(false));
}

TEST(OriginalValues, OfAResumedRunMustBeThere) {
  const auto scratch = memory_scratch();
  WorkMesh<float> layout;
  layout.point_columns = layout.cell_columns = {Column()};
  for (const bool of_cells : {false, true}) {
    ColumnsToFit columns;
    (of_cells ? columns.cells : columns.points) = {0};
    OriginalValues<float> values(scratch.get(), layout, columns, false);
    Checkpoint from;
    values.resume({}, &from);  // none had been put aside
    EXPECT_EQ(values.chunks(), 0u);
    try {
      values.resume({3, {1}}, &from);
      FAIL();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("lacks the original's values"));
    }
  }
}

// As where the first round turns out to be of no use.
TEST(OriginalValues, CanBeginAgain) {
  auto mesh = testing::to_work_mesh(five_split_cube(3, 0.1, 2));
  mesh.point_columns = {testing::make_column(1, Vector<double>(mesh.vertex_count(), 4.0))};
  mesh.cell_columns = {testing::make_column(1, Vector<double>(mesh.tets.size(), 4.5)),
                       testing::make_column(1, Vector<double>(mesh.tets.size(), 4))};
  const auto scratch = memory_scratch();
  OriginalValues<double> values(scratch.get(), mesh, {{0}, {0, 1}, {}}, false);
  values.begin();
  values.add(0, mesh);
  values.add(1, mesh);
  EXPECT_EQ(values.keep().chunks, 0u);  // not whole yet
  values.begin();
  values.add(0, mesh);
  values.end();
  EXPECT_EQ(values.chunks(), 1u);
  EXPECT_EQ(values.points()->store().bytes(), 8 + mesh.vertex_count() * (3 * 8 + 8));
  EXPECT_EQ(values.cells()->store().bytes(), 8 + mesh.tets.size() * (5 * 8 + 8 + 8));
  EXPECT_EQ(values.columns_to_average(), std::vector<std::uint32_t>{0});
  // From 2^53 on all numbers are whole.
  mesh.cell_columns[1] = testing::make_column(1, Vector<double>(mesh.tets.size(), 0x1p60));
  values.begin();
  values.add(0, mesh);
  EXPECT_EQ(values.columns_to_average(), (std::vector<std::uint32_t>{0, 1}));
}

}  // namespace
}  // namespace tetfusion
