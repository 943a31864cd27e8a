// Fusions of one pass, and undone again.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "kernel/fuse/fuse_round.h"
#include "kernel/greedy_pass.h"
#include "refine/refinable_mesh.h"
#include "support/fuse_meshes.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_cube;
using testing::limits_of;
using testing::make_column;
using testing::number_tets;
using testing::steered;

// Puts a mesh of these to the numbers that it had.
class Undone {
 public:
  explicit Undone(const WorkMesh<double>& original)
      : counts_{original.vertex_count(), original.tets.size(), original.tets.size(), 0, 0, 0},
        mesh(counts_, point_row_bytes(original), tet_row_bytes(original),
             [](const std::string& what) { throw std::runtime_error(what); }) {}

  void begin(const WorkMesh<double>& base) {
    PointRows points;
    points.numbers = base.point_ids;
    points.rows.resize(base.vertex_count() * point_row_bytes(base));
    for (std::size_t v = 0; v < base.vertex_count(); ++v) {
      copy_point_row(base, v, points.rows.data() + v * point_row_bytes(base));
    }
    mesh.add_points(points);
    TetRows tets;
    const auto numbers = original_numbers(base);
    tets.numbers.assign(numbers.begin(), numbers.end());
    tets.rows.resize(base.tets.size() * tet_row_bytes(base));
    for (std::size_t t = 0; t < base.tets.size(); ++t) {
      Tet tet = base.tets[t];
      for (VertexId& v : tet) v = base.point_ids[v];
      tets.corners.push_back(tet);
      copy_tet_row(base, t, tets.rows.data() + t * tet_row_bytes(base));
    }
    mesh.add_tets(tets);
  }

  void expect(const WorkMesh<double>& original) const {
    ASSERT_EQ(mesh.points(), original.vertex_count());
    ASSERT_EQ(mesh.tets(), original.tets.size());
    std::vector<std::byte> row(point_row_bytes(original));
    for (std::size_t v = 0; v < original.vertex_count(); ++v) {
      copy_point_row(original, v, row.data());
      EXPECT_EQ(std::memcmp(row.data(), mesh.point_row(v), row.size()), 0) << "point " << v;
    }
    row.resize(tet_row_bytes(original));
    for (std::size_t t = 0; t < original.tets.size(); ++t) {
      const auto corners = mesh.corners_of(t);
      EXPECT_TRUE(std::equal(corners.begin(), corners.end(), original.tets[t].begin()))
          << "tetrahedron " << t;
      copy_tet_row(original, t, row.data());
      EXPECT_EQ(std::memcmp(row.data(), mesh.cell_row(t), row.size()), 0) << "tetrahedron " << t;
    }
  }

 private:
  ProgressiveCounts counts_;

 public:
  RefinableMesh mesh;
};

// Arrays beside the one that steers, and tetrahedra that are known by their numbers.
void give_rows(WorkMesh<double>* mesh) {
  const std::size_t points = mesh->vertex_count();
  Vector<float> vector(3 * points);
  for (std::size_t i = 0; i < vector.size(); ++i) {
    vector[i] = static_cast<float>(testing::uniform(5, i));
  }
  mesh->point_columns.push_back(make_column(3, vector));
  Vector<std::int16_t> names(points);
  std::iota(names.begin(), names.end(), std::int16_t{-7});
  mesh->point_columns.push_back(make_column(1, names));
  Vector<double> of_tets(mesh->tets.size());
  for (std::size_t i = 0; i < of_tets.size(); ++i) of_tets[i] = testing::uniform(6, i);
  mesh->cell_columns.push_back(make_column(1, of_tets));
  number_tets(mesh);
}

void undo_all(const FusionLog& log, RefinableMesh* mesh) {
  for (std::size_t i = log.size(); i > 0; --i) mesh->undo(log[i - 1]);
}

// A mesh before and after a round, with its log.
struct NotedRound {
  NotedRound(testing::Steered steered, const FuseLimits& limits) {
    give_rows(&steered.mesh);
    original = steered.mesh;
    fused = FuseRound<double>().run(limits, steered.fields(), &steered.mesh, &log).pass.fused;
    mesh = std::move(steered.mesh);
  }

  WorkMesh<double> original, mesh;
  FusionLog log;
  std::uint64_t fused = 0;
};

NotedRound one_fusion() {
  FuseLimits limits = limits_of();
  limits.quota = 7;  // no two fusions
  return {steered(five_split_cube(3), testing::smooth), limits};
}

TEST(Undo, OneFusionOfTwoNeighbours) {
  const auto [original, mesh, log, fused] = one_fusion();
  ASSERT_EQ(fused, 1U);
  ASSERT_EQ(log.size(), 1U);
  const FusionRecord record = log[0];
  EXPECT_EQ(record.gone, 1U);
  EXPECT_EQ(record.points.size(), 1U);
  EXPECT_EQ(record.tets.size(), original.tets.size() - mesh.tets.size());
  EXPECT_EQ(log.tets(), record.tets.size());
  EXPECT_TRUE(record.elsewhere.empty());
  Undone undone(original);
  undone.begin(mesh);
  undone.mesh.undo(record);
  undone.expect(original);
}

TEST(Undo, AllFusionsOfARound) {
  const auto [original, mesh, log, fused] =
      NotedRound(steered(five_split_cube(7, 0.15, 2), testing::rough), limits_of());
  ASSERT_GT(fused, 60U);
  ASSERT_EQ(log.size(), fused);
  Undone undone(original);
  undone.begin(mesh);
  undo_all(log, &undone.mesh);
  undone.expect(original);
}

// Rows follow each fusion at once where they are noted, and all at the end where they are not.
TEST(Undo, ALogChangesNothing) {
  auto s = steered(five_split_cube(7, 0.15, 2), testing::rough);
  give_rows(&s.mesh);
  auto noted = s;
  FusionLog log;
  FuseRound<double> round;
  round.run(limits_of(), s.fields(), &s.mesh);
  round.run(limits_of(), noted.fields(), &noted.mesh, &log);
  ASSERT_EQ(s.mesh.tets, noted.mesh.tets);
  for (std::size_t c = 0; c < s.mesh.point_columns.size(); ++c) {
    EXPECT_EQ(s.mesh.point_columns[c].rows, noted.mesh.point_columns[c].rows);
  }
  EXPECT_EQ(s.mesh.steering, noted.mesh.steering);
}

TEST(Undo, AllPassesOfTetFuse) {
  WorkMesh<double> mesh = testing::to_work_mesh(five_split_cube(8, 0.1, 3));
  give_rows(&mesh);
  const WorkMesh<double> original = mesh;
  FusionLog log;
  GreedyPass<double> pass;
  PassLimits limits;
  std::uint64_t fused = 0;
  for (int i = 0; i < 4; ++i, ++limits.number) fused += pass.run(limits, {}, &mesh, &log).fused;
  ASSERT_GT(fused, 20U);
  ASSERT_EQ(log.size(), fused);
  Undone undone(original);
  undone.begin(mesh);
  undo_all(log, &undone.mesh);
  undone.expect(original);
}

// What a file with the right checksums may still say.
TEST(Undo, ARecordThatDoesNotFitIsRefused) {
  const NotedRound round = one_fusion();
  const FusionLog& log = round.log;
  const auto refuses = [&](const auto& change) {
    Undone undone(round.original);
    undone.begin(round.mesh);
    FusionRecord record = log[0];
    change(&record);
    EXPECT_THROW(undone.mesh.undo(record), std::runtime_error);
  };
  refuses([](FusionRecord* r) { r->kept = 1U << 30; });
  refuses([](FusionRecord* r) { r->kept = r->points[0]; });
  refuses([](FusionRecord* r) { r->star = r->star.first(r->star.size() - 1); });
  const VertexId kept = log[0].kept;
  refuses([&](FusionRecord* r) { r->points = {&kept, 1}; });
  const Vector<TetId> there(log[0].tets.size(), original_numbers(round.mesh)[0]);
  refuses([&](FusionRecord* r) { r->tets = there; });
  Vector<std::array<CornerCode, 4>> codes(log[0].corners.begin(), log[0].corners.end());
  codes.back()[2] = 500;
  refuses([&](FusionRecord* r) { r->corners = codes; });
}

}  // namespace
}  // namespace tetfusion
