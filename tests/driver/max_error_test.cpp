// Bounds on the error at the original's points, from file to file: what `compare` measures is
// within them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numeric>

#include "base/error.h"
#include "compare/compare.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "support/comparison.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/point_deviation.h"
#include "support/rounds_engine.h"
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

MeshFile box_with_offset_wave(std::uint32_t n, bool floats = true) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  if (floats) file.geometry = testing::to_float(file.geometry);
  const auto wave = [&](const P& p) { return 20 + std::sin(6 * p.x / n) * p.y + p.z; };
  file.point_arrays.push_back(floats ? point_array<float>(file, "wave", wave)
                                     : point_array<double>(file, "wave", wave));
  return file;
}

std::uint64_t refused(const SimplifyReport& report) {
  return report.rounds.back().pass.rejected[static_cast<std::size_t>(Reject::kDeviation)];
}

class MaxError : public ::testing::Test {
 protected:
  SimplifyReport run(const MeshFile& file) {
    file.write(request.input);
    return simplify(request);
  }
  Comparison compare() const {
    const auto original = open_mesh(request.input), simplified = open_mesh(request.output);
    return compare_meshes(original.get(), simplified.get(), {});
  }
  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
};

TEST_F(MaxError, CompareFindsNothingBeyondIt) {
  for (const bool floats : {false, true}) {
    const MeshFile file = box_with_offset_wave(14, floats);
    for (const std::uint64_t chunk_tets : {200'000, 3000}) {
      request.behaviour.chunk_tets = chunk_tets;
      std::uint64_t tets = file.geometry.tets.size();
      for (const double max_error : {1e-3, 1e-2, 5e-2}) {
        request.behaviour.max_error = max_error;
        const SimplifyReport report = run(file);
        EXPECT_EQ(report.stop_reason, StopReason::kSaturated);
        EXPECT_LT(report.output.tets, tets);
        tets = report.output.tets;
        const Comparison comparison = compare();
        const double error = array_of(comparison, "wave").max;
        EXPECT_LE(error, max_error);
        EXPECT_TRUE(error > 0.9 * max_error || max_error > 0.01) << error;
        EXPECT_EQ(comparison.outside_points, 0u);
        const auto bounds = judge_bounds(comparison, {{}, max_error, {}, {}});
        ASSERT_EQ(bounds.size(), 1u);
        EXPECT_FALSE(bounds[0].broken);
      }
    }
  }
}

TEST_F(MaxError, IsOnePercentWhereNothingIsSaid) {
  const MeshFile file = box_with_offset_wave(10);
  EXPECT_GT(refused(run(file)), 0u);
  const std::string by_default = bytes_of(request.output);
  request.behaviour.max_error = 0.01;
  run(file);
  EXPECT_EQ(bytes_of(request.output) == by_default, true);
  request.behaviour.max_error.reset();
  request.behaviour.max_rms = 0.01;
  EXPECT_EQ(refused(run(file)), 0u);
  request.behaviour.max_rms.reset();
  request.behaviour.reduction = 0.65;
  EXPECT_EQ(refused(run(file)), 0u);
  EXPECT_GT(array_of(compare(), "wave").max, 0.01);
}

// As who tries a goal without a bound wants it.
TEST_F(MaxError, AGoalThatCostsTooMuchIsGivenUp) {
  request.behaviour.reduction = 0.7;
  run(box_with_offset_wave(10));
  const std::string whole = bytes_of(request.output);
  std::filesystem::remove(request.output);
  request.behaviour.give_up_rms = 1e-4;
  EXPECT_THROW(simplify(request), OutOfReach);
  EXPECT_FALSE(std::filesystem::exists(request.output));
  request.behaviour.give_up_rms = 1;
  simplify(request);
  EXPECT_TRUE(bytes_of(request.output) == whole);
}

// With several limits the first one reached stops.
TEST_F(MaxError, GoesBeforeTheGoalAndWithTheMean) {
  const MeshFile file = box_with_offset_wave(12);
  request.behaviour.max_error = 0.001;
  request.behaviour.reduction = 0.9;
  EXPECT_THAT(run(file).stop_sentence(), HasSubstr("at a point of the original"));
  request.behaviour.reduction.reset();
  request.behaviour.max_error = 0.01;
  const std::uint64_t alone = run(file).output.tets;
  request.behaviour.reduction = 0.99;
  const SimplifyReport beyond = run(file);
  EXPECT_EQ(beyond.stop_reason, StopReason::kSaturated);
  EXPECT_GT(refused(beyond), 0u);
  EXPECT_LE(array_of(compare(), "wave").max, 0.01);
  request.behaviour.reduction = 0.2;
  EXPECT_EQ(run(file).stop_reason, StopReason::kGoal);
  EXPECT_LE(array_of(compare(), "wave").max, 0.01);
  request.behaviour.reduction.reset();
  request.behaviour.max_rms = 1e-4;
  EXPECT_GT(run(file).output.tets, alone);
}

// With a goal the bound rises from round to round: what a size does not need is not used.
TEST_F(MaxError, RisesTowardsAGoal) {
  const MeshFile file = box_with_offset_wave(14);
  request.behaviour.reduction = 0.6;
  const std::uint64_t free = run(file).output.tets;
  const double freely = array_of(compare(), "wave").max;
  request.behaviour.max_error = 0.5;
  const SimplifyReport report = run(file);
  EXPECT_EQ(report.stop_reason, StopReason::kGoal);
  EXPECT_NEAR(static_cast<double>(report.output.tets), static_cast<double>(free), 20);
  EXPECT_LT(array_of(compare(), "wave").max, 0.8 * freely);
  // A goal that is out of reach gets all of it.
  request.behaviour.reduction = 0.99;
  request.behaviour.max_error = 0.01;
  EXPECT_EQ(run(file).stop_reason, StopReason::kSaturated);
  EXPECT_LE(array_of(compare(), "wave").max, 0.01);
  EXPECT_GT(array_of(compare(), "wave").max, 0.0099);
}

// A flat tip of one tetrahedron can go without any that would hold its point then.
TEST_F(MaxError, WhereNoTetrahedronIsLeftRoundAPoint) {
  MeshFile file;
  file.geometry =
      testing::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0.3, 0.3, 0.01}},
                         {{0, 2, 1, 3}, {0, 1, 2, 4}});
  file.point_arrays.push_back(point_array<float>(file, "x", [](const P& p) { return p.x; }));
  request.behaviour.min_quality = 0;
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.2;
  for (const double max_error : {0.01, 0.9}) {
    request.behaviour.max_error = max_error;
    run(file);
    EXPECT_LE(array_of(compare(), "x").max, max_error);
  }
}

TEST_F(MaxError, ArraysHaveBoundsOfTheirOwn) {
  MeshFile file = box_with_offset_wave(12);
  file.point_arrays.push_back(point_array<double>(
      file, "ripple", [](const P& p) { return std::cos(p.y) + std::sin(p.z / 2); }));
  request.behaviour.arrays = {"wave:0.2%", "ripple"};
  request.behaviour.max_error = 0.05;
  run(file);
  EXPECT_LE(array_of(compare(), "wave").max, 0.002);
  const double ripple = array_of(compare(), "ripple").max;
  EXPECT_LE(ripple, 0.05);
  EXPECT_GT(ripple, 0.01);
  request.behaviour.max_error.reset();  // the other one has no bound
  run(file);
  EXPECT_LE(array_of(compare(), "wave").max, 0.002);
  EXPECT_GT(array_of(compare(), "ripple").max, 0.05);
}

TEST_F(MaxError, AVectorsErrorIsALength) {
  MeshFile file = box_with_offset_wave(12);
  file.point_arrays = {testing::make_array<float>("v", file.points(), 3, [&](auto i, auto k) {
    const P p = testing::point(file.geometry, static_cast<VertexId>(i));
    return k == 0 ? std::sin(p.x / 2) : k == 1 ? std::cos(p.y / 2 + 1) : std::sin(p.z / 3);
  })};
  for (const double max_error : {0.005, 0.02}) {
    request.behaviour.max_error = max_error;
    const SimplifyReport report = run(file);
    EXPECT_LT(report.output.tets, report.input.tets);
    EXPECT_LE(array_of(compare(), "v").max, max_error);
  }
}

TEST_F(MaxError, ALinearFieldGoesAsFarAsItsGeometry) {
  MeshFile file = box_with_offset_wave(12, false);
  file.point_arrays = {
      point_array<double>(file, "linear", [](const P& p) { return 3 * p.x - p.y + 2 * p.z; })};
  request.behaviour.max_error = 1e-6;
  const SimplifyReport report = run(file);
  EXPECT_EQ(refused(report), 0u);
  EXPECT_GT(report.reduction(), 0.6);
  EXPECT_LT(array_of(compare(), "linear").max, 1e-12);
}

TEST_F(MaxError, TheMeshsScaleDoesNotMatter) {
  const MeshFile file = box_with_offset_wave(9, false);
  for (const bool has_goal : {false, true}) {
    if (has_goal) {
      request.behaviour.max_error.reset();
      request.behaviour.reduction = 0.6;
    } else {
      request.behaviour.max_error = 0.01;
    }
    std::vector<Tet> expected;
    for (const int exponent : {0, -20, 20}) {
      MeshFile scaled = file;
      const double scale = std::ldexp(1.0, exponent);
      for (P& p : std::get<Vector<P>>(scaled.geometry.points)) {
        p = {p.x * scale, p.y * scale, p.z * scale};
      }
      EXPECT_GT(run(scaled).reduction(), 0.1);
      const Geometry out = open_mesh(request.output)->read_geometry();
      const std::vector<Tet> tets(out.tets.begin(), out.tets.end());
      if (exponent == 0) expected = tets;
      EXPECT_EQ(tets == expected, true) << exponent;
    }
  }
}

// Coordinates in single precision, with few digits left for what is between them: points come to
// lie on faces and edges, and compare may find them on either side.
TEST_F(MaxError, HoldsFarFromTheOrigin) {
  for (const double offset : {1e3, 1e5}) {
    MeshFile file;
    file.geometry = five_split_cube(12, 0.15, 4);
    for (P& p : std::get<Vector<P>>(file.geometry.points)) {
      p = {p.x + offset, p.y - offset, p.z + 2 * offset};
    }
    file.geometry = testing::to_float(file.geometry);
    file.point_arrays.push_back(point_array<float>(file, "wave", [&](const P& p) {
      return 1e3 + std::sin((p.x - offset) / 2) * (p.y + offset) + std::cos(p.z - 2 * offset);
    }));
    for (const double max_error : {1e-3, 1e-2, 1e-1}) {
      request.behaviour.max_error = max_error;
      const SimplifyReport report = run(file);
      EXPECT_LT(report.output.tets, report.input.tets);
      EXPECT_LE(array_of(compare(), "wave").max, max_error) << offset;
    }
  }
}

// Points of the boundary go, too, and then lie on its flat parts, but for rounding.
TEST_F(MaxError, HoldsWhereTheBoundaryIsTriangulatedAnew) {
  request.behaviour.boundary = Boundary::kPlanar;
  for (const bool floats : {false, true}) {
    const MeshFile file = box_with_offset_wave(12, floats);
    for (const double max_error : {1e-2, 5e-2}) {
      request.behaviour.max_error = max_error;
      const SimplifyReport report = run(file);
      EXPECT_LT(report.output.boundary_triangles, report.input.boundary_triangles);
      EXPECT_LE(array_of(compare(), "wave").max, max_error);
    }
  }
}

// Points outside are compared with what is nearest on the surface.
TEST_F(MaxError, HoldsWhereTheBoundaryMoves) {
  request.behaviour.boundary = Boundary::kWithin;
  for (const bool floats : {false, true}) {
    MeshFile file;
    file.geometry = five_split_cube(12, 0.15, 4);
    for (P& p : std::get<Vector<P>>(file.geometry.points)) {
      p.z += 0.04 * p.z * std::sin(p.x) * std::cos(0.8 * p.y);
    }
    if (floats) file.geometry = testing::to_float(file.geometry);
    const auto front = [](const P& p) { return std::tanh(p.x + 0.5 * p.y - 9) + p.z / 20; };
    file.point_arrays.push_back(floats ? point_array<float>(file, "front", front)
                                       : point_array<double>(file, "front", front));
    std::uint64_t outside = 0;
    for (const double distance : {0.003, 0.02}) {
      request.behaviour.boundary_distance = distance;
      for (const std::uint64_t chunk_tets : {200'000, 2500}) {
        request.behaviour.chunk_tets = chunk_tets;
        for (const double max_error : {3e-3, 3e-2}) {
          request.behaviour.max_error = max_error;
          const SimplifyReport report = run(file);
          EXPECT_LT(report.output.boundary_triangles, report.input.boundary_triangles);
          const Comparison comparison = compare();
          EXPECT_LE(array_of(comparison, "front").max, max_error);
          outside += comparison.outside_points;
        }
      }
    }
    EXPECT_GT(outside, 50u);
  }
}

// Points that no tetrahedron uses have no say in what a share of the range, or of the diagonal, is.
TEST_F(MaxError, RangeAndDiagonalAreThoseOfThePointsInUse) {
  const MeshFile plain = box_with_offset_wave(9, false);
  MeshFile file = plain;
  std::get<Vector<P>>(file.geometry.points).push_back({1e8, -7, 1});
  DataArray& wave = file.point_arrays[0];
  wave.bytes.resize(wave.bytes.size() + sizeof(double));
  wave.info.tuples += 1;
  wave.as<double>().back() = 1e30;
  const auto limit = [&](int i) {
    BehaviourOptions& options = request.behaviour = {};
    if (i == 0) options.max_error = 0.01;
    if (i == 1) options.max_rms = 0.001;
    if (i == 2) options.arrays = {"wave:1%"};
    if (i == 3) {
      options.method = Method::kTetFuse;
      options.scalar_tolerance = {0.02};
    }
    if (i == 4) {
      options.reduction = 0.9;
      options.boundary = Boundary::kWithin;
      options.boundary_distance = 0.01;
    }
  };
  for (int i = 0; i < 5; ++i) {
    SCOPED_TRACE(i);
    limit(i);
    const SimplifyReport expected = run(plain);
    const auto bytes = bytes_of(request.output);
    EXPECT_LT(expected.output.tets, expected.input.tets);
    const SimplifyReport report = run(file);
    EXPECT_EQ(report.facts.unused_points, 1u);
    EXPECT_EQ(bytes_of(request.output), bytes);
    EXPECT_EQ(report.rounds.back().deviation, expected.rounds.back().deviation);
  }
}

TEST_F(MaxError, RefusesBoundsThatAreNone) {
  const MeshFile file = box_with_offset_wave(3);
  for (const double error : {0.0, -0.1, std::nan("")}) {
    request.behaviour.max_error = error;
    try {
      run(file);
      ADD_FAILURE() << error;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      EXPECT_THAT(e.what(), HasSubstr("--max-error"));
    }
  }
}

// Over rounds whose cut moves: each point of the original is at every time where a chunk checks it.
TEST(MaxErrorRounds, EveryPointIsWithinTheBoundAfterEveryRound) {
  WorkMesh<double> mesh = testing::to_work_mesh(five_split_cube(10, 0.2, 7));
  testing::steer_by([](double x, double y, double z) { return std::sin(x / 2) + y * z / 20; },
                    &mesh);
  mesh.quadric_width = quadric_row(1);
  mesh.quadrics.assign(mesh.vertex_count() * mesh.quadric_width, 0.0F);
  const auto [least, most] = std::minmax_element(mesh.steering.begin(), mesh.steering.end());
  const SteeringField field{0, 1, *most - *least, {}};
  for (const std::uint64_t chunk_tets : {700, 1500}) {
    testing::RoundsEngine engine(mesh, chunk_tets);
    engine.fields = {&field, 1};
    engine.settings.method = Method::kFuse;
    engine.settings.fuse.unit = 0x1p-4;
    engine.settings.fuse.min_quality = 0.2;
    engine.settings.fuse.max_error = 0.01;
    engine.settings.is_first = true;
    engine.settings.look = true;
    engine.run(1);
    engine.settings.is_first = false;
    engine.settings.look = false;
    std::uint64_t refusals = 0;
    for (const double threshold : {1e-6, 1e-5, 1e-4, 1e-3, 1e-3}) {
      ASSERT_GT(engine.lod.chunks, 1u);
      engine.settings.fuse.threshold = threshold;
      const RoundStatistics round = engine.run();
      refusals += round.pass.rejected[static_cast<std::size_t>(Reject::kDeviation)];
      const WorkMesh<double> now = engine.mesh();
      EXPECT_LE(testing::worst_deviation(mesh, now, field), 0.01);
      const auto vertices = std::count_if(now.marks.begin(), now.marks.end(),
                                          [](std::uint8_t m) { return (m & kMoved) == 0; });
      EXPECT_EQ(static_cast<std::size_t>(vertices) + now.removed.size(), mesh.vertex_count());
      EXPECT_TRUE(engine.lod.whole || engine.lod.removed == now.removed.size());
    }
    EXPECT_GT(refusals, 0u);
    EXPECT_LT(engine.lod.tets, mesh.tets.size() * 2 / 3);
  }
}

}  // namespace
}  // namespace tetfusion
