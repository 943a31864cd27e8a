#include "driver/rounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/inspect.h"
#include "mesh/predicates.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

template <class Real>
double volume(const WorkMesh<Real>& mesh) {
  double sum = 0;
  for (const Tet& t : mesh.tets) sum += determinant(mesh.positions, t).value / 6;
  return sum;
}

struct Outcome {
  WorkMesh<double> mesh;
  FuseLog log;
  std::vector<RoundStatistics> rounds;
};

Outcome run(WorkMesh<double> mesh, std::uint64_t chunk_tets, int threads, int rounds) {
  Outcome outcome{std::move(mesh), {}, {}};
  Rounds<double> engine(chunk_tets, threads);
  PassLimits limits;
  limits.stretch_factor = 5;
  for (int i = 0; i < rounds; ++i, ++limits.number) {
    outcome.rounds.push_back(engine.run(limits, {}, {}, &outcome.mesh, &outcome.log));
  }
  return outcome;
}

TEST(Rounds, ChunksMakeAValidMesh) {
  const WorkMesh<double> before = testing::to_work_mesh(testing::five_split_cube(16, 0.2, 5));
  for (const std::uint64_t chunk_tets : {300, 2000, 10000}) {
    const Outcome outcome = run(before, chunk_tets, 2, 6);
    EXPECT_GT(outcome.rounds[0].chunks, 1u);
    Geometry g;
    g.points = outcome.mesh.positions;
    g.tets = outcome.mesh.tets;
    const Inspection inspection = inspect(g);
    EXPECT_EQ(inspection.rewound + inspection.degenerate + inspection.inverted, 0u);
    EXPECT_EQ(
        inspection.foldover_faces + inspection.overfull_faces + inspection.nonmanifold_vertices,
        0u);
    EXPECT_EQ(inspection.boundary_faces, 16u * 16 * 12);
    EXPECT_EQ(inspection.components, 1u);
    EXPECT_NEAR(volume(outcome.mesh), 4096.0, 1e-9);
    EXPECT_LT(outcome.mesh.tets.size(), before.tets.size() * 19 / 20);
    WorkMesh<double> counted = outcome.mesh;
    count_incidence(&counted);
    EXPECT_EQ(counted.incidence, outcome.mesh.incidence);
    // Three vertices a fusion, and now and then one that a cavity swallows.
    EXPECT_LE(outcome.mesh.vertex_count(), before.vertex_count() - 3 * outcome.log.size());
    EXPECT_EQ(std::count(outcome.mesh.incidence.begin(), outcome.mesh.incidence.end(), 0u), 0);
  }
}

TEST(Rounds, TheResultDoesNotDependOnThreads) {
  const WorkMesh<double> before = testing::to_work_mesh(testing::kuhn_box(14, 13, 12, 0.2, 8));
  const Outcome one = run(before, 700, 1, 5);
  for (const int threads : {2, 3, 8}) {
    const Outcome many = run(before, 700, threads, 5);
    EXPECT_EQ(many.mesh.tets, one.mesh.tets);
    EXPECT_EQ(many.mesh.point_ids, one.mesh.point_ids);
    EXPECT_EQ(many.mesh.tet_ids, one.mesh.tet_ids);
    EXPECT_EQ(many.log.nearest, one.log.nearest);
    for (std::size_t r = 0; r < one.rounds.size(); ++r) {
      EXPECT_EQ(many.rounds[r].pass.rejected, one.rounds[r].pass.rejected);
    }
  }
}

// Interfaces dissolve: with several small chunks nearly as much is fused in the end as with one.
TEST(Rounds, CutsCostNothingInTheEnd) {
  const WorkMesh<double> before = testing::to_work_mesh(testing::kuhn_box(16, 16, 16, 0.15, 2));
  const std::size_t whole = run(before, 1'000'000, 1, 12).mesh.tets.size();
  const std::size_t cut = run(before, 5000, 1, 24).mesh.tets.size();
  EXPECT_LT(static_cast<double>(cut), 1.1 * static_cast<double>(whole));
}

TEST(Rounds, TheQuotaIsSharedAndNeverExceeded) {
  const WorkMesh<double> before = testing::to_work_mesh(testing::five_split_cube(16, 0.1, 5));
  for (const bool spread : {true, false}) {
    WorkMesh<double> mesh = before;
    PassLimits limits;
    limits.quota = 1500;
    limits.spread = spread;
    FuseLog log;
    Rounds<double> engine(2000, 2);
    engine.run(limits, {}, {}, &mesh, &log);
    const std::size_t removed = before.tets.size() - mesh.tets.size();
    EXPECT_LE(removed, 1500u);
    EXPECT_GT(removed, spread ? 800u : 1440u);
  }
}

// The log's fusions name the points of the beginning, so that arrays can follow.
TEST(Rounds, TheLogLeadsBackToTheInput) {
  const WorkMesh<double> before = testing::to_work_mesh(testing::five_split_cube(14, 0.2, 6));
  const Outcome outcome = run(before, 1500, 2, 5);
  Vector<double> xs;
  for (const auto& p : before.positions) xs.push_back(p.x);
  DataArray array;
  array.info = {"x", ValueType::kFloat64, 1, {}, xs.size()};
  array.bytes.resize(xs.size() * sizeof(double));
  std::copy(xs.begin(), xs.end(), array.as<double>().begin());
  carry_point_array(outcome.log, {}, &array);
  for (std::size_t v = 0; v < outcome.mesh.vertex_count(); ++v) {
    EXPECT_NEAR(array.as<double>()[outcome.mesh.point_ids[v]], outcome.mesh.positions[v].x, 1e-12);
  }
}

TEST(Rounds, StopBetweenChunksWhenCancelled) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(10, 0.1, 6));
  std::atomic<bool> cancelled{true};
  RunContext context;
  context.cancelled = &cancelled;
  FuseLog log;
  Rounds<double> engine(500, 2);
  EXPECT_THROW(engine.run({}, {}, context, &mesh, &log), Error);
}

}  // namespace
}  // namespace tetfusion
