// Runs with --method fuse, from file to file and over the rounds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/error.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "mesh/inspection/inspect.h"
#include "mesh/quality.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/rounds_engine.h"
#include "support/surfaces.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::boundary_of;
using testing::bytes_of;
using ::testing::ElementsAre;
using testing::five_split_cube;
using ::testing::HasSubstr;
using testing::kuhn_box;
using testing::make_array;
using testing::MeshFile;
using testing::point_array;
using testing::read_point_array;
using testing::RoundsEngine;
using testing::TempDir;

using P = Vec3<double>;

MeshFile box_with_wave(std::uint32_t n) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  file.point_arrays.push_back(point_array<float>(
      file, "wave", [&](const P& p) { return std::sin(6 * p.x / n) * p.y + p.z; }));
  return file;
}

class Fuse : public ::testing::Test {
 protected:
  SimplifyReport run(const MeshFile& file) {
    file.write(request.input);
    return simplify(request);
  }
  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
};

TEST_F(Fuse, TheGoalIsMetFromAbove) {
  const MeshFile file = box_with_wave(20);
  const auto tets = static_cast<double>(file.geometry.tets.size());
  for (const std::uint64_t chunk_tets : {200'000, 6000}) {
    request.behaviour.chunk_tets = chunk_tets;
    for (const double reduction : {0.0, 0.01, 0.5, 0.8}) {
      request.behaviour.reduction = reduction;
      const SimplifyReport report = run(file);
      EXPECT_EQ(report.stop_reason, StopReason::kGoal) << reduction;
      EXPECT_GE(static_cast<double>(report.output.tets), tets * (1 - reduction) - 1e-6);
      EXPECT_LT(static_cast<double>(report.output.tets), tets * (1 - reduction) + 12);
      EXPECT_NEAR(report.output.volume / report.input.volume, 1, 1e-12);
    }
    const Geometry out = open_mesh(request.output)->read_geometry();
    EXPECT_EQ(boundary_of(out), boundary_of(file.geometry));
    Geometry inspected = out;
    const Inspection inspection = inspect(inspected);
    EXPECT_EQ(inspection.degenerate + inspection.inverted + inspection.foldover_faces, 0u);
  }
  request.behaviour.reduction = 0.99;
  EXPECT_EQ(run(file).stop_reason, StopReason::kSaturated);
}

// What may become of flat cells is known from round to round, wherever chunks are cut.
TEST_F(Fuse, EvenLayersAreNeitherFrozenNorWrecked) {
  MeshFile file;
  file.geometry = kuhn_box(16, 16, 16);
  for (P& p : std::get<Vector<P>>(file.geometry.points)) p.z *= 0.02;
  file.point_arrays.push_back(
      point_array<float>(file, "wave", [&](const P& p) { return std::sin(p.x / 5) + p.y / 3; }));
  const auto worst = [](const Geometry& geometry) {
    return measure_quality(geometry).mean_ratio.min;
  };
  request.behaviour.reduction = 0.9;
  for (const std::uint64_t chunk_tets : {200'000, 3000}) {
    request.behaviour.chunk_tets = chunk_tets;
    const SimplifyReport report = run(file);
    EXPECT_LT(report.output.tets, file.geometry.tets.size() / 2);
    EXPECT_GT(report.rounds.size(), 4u);
    EXPECT_GE(worst(open_mesh(request.output)->read_geometry()), 0.95 * worst(file.geometry));
  }
}

// Two parts that lie over each other, each with values of its own.
TEST_F(Fuse, ValuesStayInTheirParts) {
  MeshFile file;
  file.geometry = five_split_cube(8, 0.1, 3);
  auto& positions = std::get<Vector<P>>(file.geometry.points);
  const std::size_t points = positions.size(), tets = file.geometry.tets.size();
  for (std::size_t v = 0; v < points; ++v) {
    positions.push_back({positions[v].x + 7, positions[v].y, positions[v].z});
  }
  for (std::size_t t = 0; t < tets; ++t) {
    Tet tet = file.geometry.tets[t];
    for (VertexId& v : tet) v += static_cast<VertexId>(points);
    file.geometry.tets.push_back(tet);
  }
  file.point_arrays.push_back(point_array<double>(
      file, "wave", [](const P& p) { return std::sin(p.x / 3) + p.y * p.z / 20; }));
  file.point_arrays.push_back(make_array<double>(
      "part", file.points(), 1, [&](std::size_t v, auto) { return v < points ? 20.5 : 120.5; }));
  file.cell_arrays.push_back(make_array<double>(
      "part", file.cells(), 1, [&](std::size_t t, auto) { return t < tets ? 20.5 : 120.5; }));
  request.behaviour.reduction = 0.5;
  for (const Boundary boundary : {Boundary::kExact, Boundary::kPlanar}) {
    request.behaviour.boundary = boundary;
    run(file);
    const auto source = open_mesh(request.output);
    for (const auto& values : {testing::point_values<double>(source.get(), "part"),
                               testing::cell_values<double>(source.get(), "part")}) {
      for (const double value : values) EXPECT_TRUE(value == 20.5 || value == 120.5) << value;
    }
  }
}

// No round is begun that could do nothing.
TEST_F(Fuse, EndsWithTheRoundThatMeetsTheGoal) {
  const MeshFile file = box_with_wave(12);
  const auto tets = static_cast<double>(file.geometry.tets.size());
  for (const std::uint64_t chunk_tets : {200'000, 3000}) {
    request.behaviour.chunk_tets = chunk_tets;
    int met = 0;
    for (const double reduction : {0.3, 0.4, 0.5, 0.6}) {
      request.behaviour.reduction = reduction;
      const SimplifyReport report = run(file);
      EXPECT_EQ(report.stop_reason, StopReason::kGoal);
      if (static_cast<double>(report.output.tets) - tets * (1 - reduction) >= 5) continue;
      ++met;
      EXPECT_GT(report.rounds.back().pass.fused, 0u) << reduction;
    }
    EXPECT_GT(met, 2);
  }
}

// What fusions cost is known from an excerpt, where there are several chunks, with bounds at
// points, too; a mesh in one piece is looked at first.
TEST_F(Fuse, BeginsWithoutALookWhereAnExcerptWillDo) {
  const MeshFile file = box_with_wave(16);
  request.behaviour.reduction = 0.5;
  request.behaviour.chunk_tets = 4000;
  EXPECT_GT(run(file).rounds.front().pass.fused, 0u);
  request.behaviour.max_error = 0.05;
  EXPECT_GT(run(file).rounds.front().pass.fused, 0u);
  request.behaviour.max_error.reset();
  request.behaviour.chunk_tets = 200'000;
  EXPECT_EQ(run(file).rounds.front().pass.fused, 0u);
}

// Nobody knows yet which ways surfaces look that may move, so they rest in the first round, which
// leaves them their part of the way to the goal.
TEST_F(Fuse, SurfacesRestInTheFirstRound) {
  const MeshFile file = box_with_wave(16);
  const auto triangles = boundary_of(file.geometry).size();
  request.behaviour.chunk_tets = 4000;
  request.behaviour.boundary = Boundary::kPlanar;
  for (const double reduction : {0.2, 0.5}) {
    request.behaviour.reduction = reduction;
    const SimplifyReport report = run(file);
    ASSERT_GT(report.rounds.size(), 1u);
    const PassStatistics& first = report.rounds.front().pass;
    EXPECT_GT(first.fused, 0u);
    const auto gone = static_cast<double>(first.tets_before - first.tets_after);
    EXPECT_LE(gone, 0.8 * reduction * static_cast<double>(first.tets_before));
    EXPECT_EQ(report.rounds.front().deviation, 0);
    EXPECT_EQ(report.stop_reason, StopReason::kGoal);
    EXPECT_LT(report.output.boundary_triangles, triangles);
  }
  // Where hardly anything is inside, it is not the end.
  request.behaviour.reduction = 0.95;
  EXPECT_EQ(run(file).stop_reason, StopReason::kGoal);
}

TEST_F(Fuse, TheErrorIsABound) {
  const MeshFile file = box_with_wave(12);
  std::uint64_t tets = file.geometry.tets.size();
  for (const double rms : {1e-4, 1e-3, 1e-2, 1.0}) {
    request.behaviour.max_rms = rms;
    const SimplifyReport report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kSaturated);
    EXPECT_LT(report.output.tets, tets);
    tets = report.output.tets;
  }
}

TEST_F(Fuse, LevelsAreWrittenOnTheWay) {
  const MeshFile file = box_with_wave(16);
  const auto tets = static_cast<double>(file.geometry.tets.size());
  request.output = folder.file("level_{lod}.vtu");
  request.behaviour.chunk_tets = 5000;
  request.behaviour.lods = {0.3, 0.5, 0.7};
  const SimplifyReport report = run(file);
  EXPECT_EQ(report.stop_reason, StopReason::kGoal);
  ASSERT_EQ(report.outputs.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Geometry g = open_mesh(report.outputs[i].path)->read_geometry();
    const double goal = tets * (1 - request.behaviour.lods[i]);
    EXPECT_GE(static_cast<double>(g.tets.size()), goal - 1e-6);
    EXPECT_LT(static_cast<double>(g.tets.size()), goal + 12);
    EXPECT_EQ(boundary_of(g), boundary_of(file.geometry));
  }
}

// The second field keeps what the first one does not need.
TEST_F(Fuse, SeveralFieldsSteer) {
  MeshFile file = box_with_wave(12);
  file.point_arrays.push_back(
      point_array<double>(file, "step", [](const P& p) { return p.y < 6.2 ? 0.0 : 1.0; }));
  const auto linear = [](const P& p) { return 3 * p.x - p.y + 2 * p.z; };
  file.point_arrays.push_back(
      make_array<float>("vector", file.points(), 3, [&](std::size_t i, std::size_t k) {
        const P p = testing::point(file.geometry, static_cast<VertexId>(i));
        return linear(k == 0 ? P{p.x, 0, 0} : (k == 1 ? P{0, p.y, 0} : p));
      }));
  file.point_arrays.push_back(point_array<double>(file, "linear", linear));
  request.behaviour.reduction = 0.5;
  // The sum of the squares at the points that are left, as if the step were y < 6.2 there.
  const auto error_of_step = [&] {
    const auto source = open_mesh(request.output);
    const Geometry g = source->read_geometry();
    const DataArray values = read_point_array(source.get(), "step");
    double sum = 0;
    for (VertexId v = 0; v < point_count(g.points); ++v) {
      const double error = values.as<double>()[v] - (testing::point(g, v).y < 6.2 ? 0 : 1);
      sum += error * error;
    }
    return sum;
  };
  request.behaviour.arrays = {"wave"};
  run(file);
  const double alone = error_of_step();
  request.behaviour.arrays = {"wave", "step", "vector"};
  const SimplifyReport report = run(file);
  EXPECT_THAT(report.steering, ElementsAre("wave", "step", "vector"));
  EXPECT_EQ(report.stop_reason, StopReason::kGoal);
  EXPECT_LT(error_of_step(), 0.5 * alone);
  const auto source = open_mesh(request.output);
  const Geometry g = source->read_geometry();
  const DataArray vectors = read_point_array(source.get(), "vector");
  const DataArray carried = read_point_array(source.get(), "linear");
  for (VertexId v = 0; v < point_count(g.points); ++v) {
    const P p = testing::point(g, v);
    EXPECT_NEAR(vectors.as<float>()[3 * v], 3 * p.x, 60 * 1e-5);
    EXPECT_NEAR(vectors.as<float>()[3 * v + 1], -p.y, 60 * 1e-5);
    EXPECT_NEAR(vectors.as<float>()[3 * v + 2], linear(p), 60 * 1e-5);
    EXPECT_NEAR(carried.as<double>()[v], linear(p), 1e-11);
  }
}

TEST_F(Fuse, WithoutAFieldGeometryAloneDecides) {
  MeshFile file = box_with_wave(12);
  file.point_arrays.clear();
  for (const std::uint64_t chunk_tets : {200'000, 2000}) {
    request.behaviour.chunk_tets = chunk_tets;
    request.behaviour.reduction = 0.5;
    const SimplifyReport report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kGoal);
    EXPECT_TRUE(report.steering.empty());
  }
}

// A field's scale and place do not matter, nor do values that are no number.
TEST_F(Fuse, AFieldsScaleHasNoLimits) {
  MeshFile file = box_with_wave(9);
  std::set<std::uint64_t> sizes;
  request.behaviour.max_rms = 0.01;
  for (const double scale : {0x1p-1000, 1.0, 0x1p1015}) {
    file.point_arrays = {point_array<double>(
        file, "f", [&](const P& p) { return std::sin(p.x / 3) * (p.y - 4.5) * scale; })};
    sizes.insert(run(file).output.tets);
    const DataArray values = read_point_array(open_mesh(request.output).get(), "f");
    for (const double v : values.as<double>()) EXPECT_TRUE(std::isfinite(v));
  }
  EXPECT_EQ(sizes.size(), 1u);
}

TEST_F(Fuse, VerticesWithoutAValueStay) {
  MeshFile file = box_with_wave(9);
  file.point_arrays = {point_array<double>(
      file, "holes", [](const P& p) { return p.x > 3 && p.x < 5 ? std::nan("") : p.x; })};
  const SimplifyReport report = run(file);
  EXPECT_GT(report.facts.locked_vertices, 0u);
  EXPECT_LT(report.output.tets, report.input.tets);
  const auto count_nan = [](const DataArray& a) {
    const auto v = a.as<double>();
    return std::count_if(v.begin(), v.end(), [](double x) { return std::isnan(x); });
  };
  EXPECT_EQ(count_nan(read_point_array(open_mesh(request.output).get(), "holes")),
            count_nan(file.point_arrays[0]));
}

TEST_F(Fuse, RefusesBoundsThatAreNone) {
  const MeshFile file = box_with_wave(3);
  const auto refusal = [&] {
    try {
      run(file);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      return std::string(e.what());
    }
    return std::string("none");
  };
  for (const double quality : {-0.1, 1.0, 1.5, std::nan("")}) {
    request.behaviour.min_quality = quality;
    EXPECT_THAT(refusal(), HasSubstr("--min-quality")) << quality;
  }
  request.behaviour.min_quality = 0;
  for (const double rms : {0.0, -0.1, std::nan("")}) {
    request.behaviour.max_rms = rms;
    EXPECT_THAT(refusal(), HasSubstr("--max-rms")) << rms;
  }
}

// Each vertex's quadric, added up over the chunks that have a part of it.
std::map<VertexId, std::vector<float>> quadrics_of(const RoundsEngine& engine) {
  const WorkMesh<double> mesh = engine.mesh();
  std::map<VertexId, std::vector<float>> out;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const float* row = mesh.quadrics.data() + v * mesh.quadric_width;
    out[mesh.point_ids[v]].assign(row, row + quadric_size(mesh.steering_width));
  }
  return out;
}

double weight_of(const std::map<VertexId, std::vector<float>>& quadrics) {
  double sum = 0;
  for (const auto& [id, q] : quadrics) sum += q[kQuadricW];
  return sum;
}

TEST(FuseRounds, PartsOfQuadricsAddUp) {
  WorkMesh<double> mesh = testing::to_work_mesh(five_split_cube(10, 0.2, 7));
  testing::steer_by([](double x, double y, double z) { return std::sin(x / 3) + y * z / 40; },
                    &mesh);
  mesh.quadric_width = quadric_row(1);
  mesh.quadrics.assign(mesh.vertex_count() * mesh.quadric_width, 0.0F);
  const SteeringField field{0, 1, 4.0, {}};
  const auto start = [&](RoundsEngine* engine) {
    engine->fields = {&field, 1};
    engine->settings.method = Method::kFuse;
    engine->settings.fuse.unit = 0x1p-4;
    engine->settings.fuse.min_quality = 0.2;
    engine->settings.is_first = true;
    engine->settings.look = true;
    engine->run(1);
    engine->settings.is_first = false;
    engine->settings.look = false;
  };
  RoundsEngine whole(mesh, 1'000'000);
  start(&whole);
  const auto expected = quadrics_of(whole);
  const double weight = weight_of(expected);
  EXPECT_NEAR(weight / (4 * 6 * 1000 * 0x1p-12), 1, 1e-6);  // determinants
  for (const std::uint64_t chunk_tets : {300, 1500}) {
    RoundsEngine cut(mesh, chunk_tets);
    start(&cut);
    ASSERT_GT(cut.lod.chunks, 2u);
    const auto quadrics = quadrics_of(cut);
    ASSERT_EQ(quadrics.size(), expected.size());
    for (const auto& [id, q] : expected) {
      const double tolerance = 1e-6 * (q[0] + q[3] + q[5]) + 1e-12;
      for (std::size_t k = 0; k < q.size(); ++k) {
        EXPECT_NEAR(quadrics.at(id)[k], q[k], k < kQuadricL ? tolerance : 1e-8) << k;
      }
    }
    // And go on adding up while vertices fuse and the cut moves.
    for (const double threshold : {1e-4, 1e-3, 1e-2}) {
      cut.settings.fuse.threshold = threshold;
      EXPECT_GT(cut.run().pass.fused, 0u);
      EXPECT_NEAR(weight_of(quadrics_of(cut)) / weight, 1, 1e-5);
    }
  }
}

}  // namespace
}  // namespace tetfusion
