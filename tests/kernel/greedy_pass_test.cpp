#include "kernel/greedy_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "mesh/inspection/inspect.h"
#include "support/meshes.h"
#include "support/reference_pass.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::all_positive;
using testing::five_split_cube;
using testing::kuhn_box;
using testing::to_float_work_mesh;
using testing::to_geometry;
using testing::to_work_mesh;
using testing::volume;

std::uint64_t rejected(const PassStatistics& s, Reject reason) {
  return s.rejected[static_cast<std::size_t>(reason)];
}

// Boundary triangles as sets of coordinates.
template <class Real>
std::set<std::set<std::array<Real, 3>>> boundary(const WorkMesh<Real>& mesh) {
  Geometry g = to_geometry(mesh);
  std::set<std::set<std::array<Real, 3>>> triangles;
  for (const auto& triangle : inspect(g).boundary_triangles) {
    std::set<std::array<Real, 3>> corners;
    for (const VertexId v : triangle) {
      const Vec3<Real>& p = mesh.positions[v];
      corners.insert({p.x, p.y, p.z});
    }
    triangles.insert(corners);
  }
  return triangles;
}

template <class Real>
void run_until_nothing_fuses(WorkMesh<Real>* mesh) {
  GreedyPass<Real> pass;
  PassLimits limits;
  while (pass.run(limits, {}, mesh).fused > 0) ++limits.number;
}

// The box of 3 x 3 x 3 cubes has 8 interior vertices, those of the middle cube, and in it 5
// candidates.
TEST(GreedyPass, FusesOneTetrahedronOfTheMiddleCube) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(3));
  const WorkMesh<double> before = mesh;
  GreedyPass<double> pass;
  const PassStatistics s = pass.run({}, {}, &mesh);

  ASSERT_EQ(s.fused, 1u);
  ASSERT_EQ(pass.fusions().size(), 1u);
  const auto& prey = pass.fusions()[0].vertices;
  std::uint64_t deleted = 0;
  for (const Tet& t : before.tets) {
    const auto in_prey = [&](VertexId v) { return std::count(prey.begin(), prey.end(), v) > 0; };
    if (std::count_if(t.begin(), t.end(), in_prey) >= 2) ++deleted;
  }
  EXPECT_EQ(s.tets_before, 135u);
  EXPECT_EQ(s.tets_after, 135u - deleted);
  EXPECT_EQ(mesh.tets.size(), s.tets_after);
  EXPECT_EQ(mesh.vertex_count(), 64u - 3u);

  Vec3<double> mean{0, 0, 0};
  for (const VertexId v : prey) {
    mean.x += before.positions[v].x / 4;
    mean.y += before.positions[v].y / 4;
    mean.z += before.positions[v].z / 4;
  }
  const auto at =
      std::find(mesh.point_ids.begin(), mesh.point_ids.end(), prey[0]) - mesh.point_ids.begin();
  const Vec3<double>& fused = mesh.positions[static_cast<std::size_t>(at)];
  EXPECT_NEAR(fused.x, mean.x, 1e-15);
  EXPECT_NEAR(fused.y, mean.y, 1e-15);
  EXPECT_NEAR(fused.z, mean.z, 1e-15);
  EXPECT_TRUE(all_positive(mesh));
  EXPECT_NEAR(volume(mesh), 27.0, 1e-12);
  EXPECT_EQ(boundary(mesh), boundary(before));
  // Every other tetrahedron has a vertex on the boundary, is labelled, or is the one that was
  // fused.
  EXPECT_EQ(s.fused + s.labelled + rejected(s, Reject::kBoundary), s.tets_before);
}

TEST(GreedyPass, LeavesAMeshWithoutInteriorTetrahedra) {
  for (const Geometry& g : {testing::single_tet(), testing::icosahedron_ball(), testing::plate(4),
                            testing::two_tets_sharing_face(), five_split_cube(2)}) {
    WorkMesh<double> mesh = to_work_mesh(g);
    const Vector<Tet> tets = mesh.tets;
    const PassStatistics s = GreedyPass<double>().run({}, {}, &mesh);
    EXPECT_EQ(s.fused, 0u);
    EXPECT_EQ(rejected(s, Reject::kBoundary), tets.size());
    EXPECT_EQ(mesh.tets, tets);
  }
}

TEST(GreedyPass, TetsRuleKeepsWhatTouchesTheBoundary) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(3));
  PassLimits limits;
  limits.boundary_rule = BoundaryRule::kTets;
  const PassStatistics s = GreedyPass<double>().run(limits, {}, &mesh);
  EXPECT_EQ(s.fused, 0u);
  EXPECT_EQ(rejected(s, Reject::kBoundary), 135u);
}

TEST(GreedyPass, LockedVerticesStay) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(3));
  for (std::uint8_t& m : mesh.marks) {
    if ((m & kOnBoundary) == 0) m |= kLocked;
  }
  const PassStatistics s = GreedyPass<double>().run({}, {}, &mesh);
  EXPECT_EQ(s.fused, 0u);
  EXPECT_EQ(rejected(s, Reject::kLocked), 5u);
}

TEST(GreedyPass, ScalarToleranceIsAShareOfTheRange) {
  for (const bool allowed : {false, true}) {
    WorkMesh<double> mesh = to_work_mesh(five_split_cube(3));
    testing::steer_by([](double x, double, double) { return x; }, &mesh);
    // x differs from its mean by at most 0.75 in a tetrahedron of a unit cube; the range is 3.
    const SteeringField field{0, 1, 3.0, {}};
    PassLimits limits;
    limits.paper.scalar_tolerance = allowed ? 0.2501 : 0.16;
    const PassStatistics s = GreedyPass<double>().run(limits, {&field, 1}, &mesh);
    EXPECT_EQ(s.fused, allowed ? 1u : 0u);
    EXPECT_EQ(rejected(s, Reject::kScalar), allowed ? 0u : 5u);
  }
}

TEST(GreedyPass, AFieldsOwnToleranceCounts) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(3));
  testing::steer_by([](double x, double, double) { return x; }, &mesh);
  const SteeringField field{0, 1, 3.0, 0.01};
  EXPECT_EQ(GreedyPass<double>().run({}, {&field, 1}, &mesh).fused, 0u);
}

// A needle of a boundary vertex pushed towards the middle: the barycenter does not see it any more.
TEST(GreedyPass, RejectsFlips) {
  Geometry g = five_split_cube(3);
  auto& points = std::get<Vector<Vec3<double>>>(g.points);
  // Interior vertices nearly on one plane turn the ring's tetrahedra over when they meet in one
  // point.
  for (Vec3<double>& p : points) {
    if (p.x == 1 && p.y >= 1 && p.y <= 2 && p.z >= 1 && p.z <= 2) p.x = p.y == 1 ? 0.05 : 1.9;
  }
  WorkMesh<double> mesh = to_work_mesh(g);
  ASSERT_TRUE(all_positive(mesh));
  PassStatistics s = GreedyPass<double>().run({}, {}, &mesh);
  EXPECT_GT(rejected(s, Reject::kFlip), 0u);
  EXPECT_TRUE(all_positive(mesh));
  EXPECT_NEAR(volume(mesh), 27.0, 1e-12);
}

testing::ReferenceMesh to_reference(const WorkMesh<double>& mesh) {
  testing::ReferenceMesh reference;
  for (const auto& p : mesh.positions) reference.points.push_back({p.x, p.y, p.z});
  reference.scalars.assign(mesh.steering.begin(), mesh.steering.end());
  for (const std::uint8_t m : mesh.marks) reference.on_boundary.push_back((m & kOnBoundary) != 0);
  for (const Tet& t : mesh.tets) reference.tets.push_back({t[0], t[1], t[2], t[3]});
  return reference;
}

struct Setting {
  bool tets_rule;
  double scalar_tolerance, stretch_factor, aspect_ratio;
};

constexpr double kOff = std::numeric_limits<double>::infinity();

class AgainstReference : public ::testing::TestWithParam<Setting> {};

TEST_P(AgainstReference, EveryPassIsTheSame) {
  const Setting setting = GetParam();
  std::uint64_t refused_for_shape = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    WorkMesh<double> mesh =
        to_work_mesh(seed == 3 ? kuhn_box(6, 5, 6, 0.15, seed) : five_split_cube(7, 0.2, seed));
    testing::steer_by([](double x, double y, double z) { return std::sin(x) + y * z / 9; }, &mesh);
    const SteeringField field{0, 1, 2.0, {}};
    PassLimits limits;
    limits.boundary_rule = setting.tets_rule ? BoundaryRule::kTets : BoundaryRule::kVertices;
    limits.paper.scalar_tolerance = setting.scalar_tolerance;
    limits.paper.stretch_factor = setting.stretch_factor;
    limits.paper.aspect_ratio = setting.aspect_ratio;
    const testing::ReferenceLimits reference_limits{setting.tets_rule,
                                                    setting.scalar_tolerance * 2.0,
                                                    setting.stretch_factor, setting.aspect_ratio};
    GreedyPass<double> pass;
    std::uint64_t fused = 0;
    for (std::uint16_t i = 1; i <= 4; ++i) {
      limits.number = i;
      const auto expected = testing::reference_pass(to_reference(mesh), reference_limits);
      const PassStatistics s = pass.run(limits, {&field, 1}, &mesh);
      ASSERT_EQ(s.fused, expected.fused);
      fused += s.fused;
      EXPECT_EQ(rejected(s, Reject::kBoundary), expected.boundary);
      EXPECT_EQ(rejected(s, Reject::kScalar), expected.scalar);
      EXPECT_EQ(rejected(s, Reject::kFlip), expected.flip);
      EXPECT_EQ(rejected(s, Reject::kStretch), expected.stretch);
      EXPECT_EQ(rejected(s, Reject::kAspect), expected.aspect);
      refused_for_shape += expected.stretch + expected.aspect;
      ASSERT_EQ(mesh.tets.size(), expected.mesh.tets.size());
      for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
        for (std::size_t c = 0; c < 4; ++c) {
          const VertexId v = mesh.tets[t][c];
          const VertexId w = expected.mesh.tets[t][c];
          EXPECT_EQ(mesh.positions[v].x, expected.mesh.points[w][0]);
          EXPECT_EQ(mesh.positions[v].y, expected.mesh.points[w][1]);
          EXPECT_EQ(mesh.positions[v].z, expected.mesh.points[w][2]);
          EXPECT_EQ(mesh.steering[v], expected.mesh.scalars[w]);
        }
      }
    }
    EXPECT_GT(fused, 0u);
    EXPECT_TRUE(all_positive(mesh));
  }
  const bool shape_is_tight = setting.stretch_factor < 10 || setting.aspect_ratio < 10;
  EXPECT_EQ(refused_for_shape > 0, shape_is_tight);
}

INSTANTIATE_TEST_SUITE_P(
    Settings, AgainstReference,
    ::testing::Values(Setting{false, kOff, kOff, kOff}, Setting{true, kOff, kOff, kOff},
                      Setting{false, 0.2, kOff, kOff}, Setting{false, kOff, 2.0, kOff},
                      Setting{false, kOff, kOff, 3.5}, Setting{true, 0.3, 2.2, 4.0}));

TEST(GreedyPass, RememberedFlipsChangeNothing) {
  const Geometry g = five_split_cube(10, 0.2, 7);
  WorkMesh<double> a = to_work_mesh(g);
  WorkMesh<double> b = a;
  GreedyPass<double> pass;
  for (std::uint16_t i = 0; i < 6; ++i) {
    PassLimits limits;
    limits.number = static_cast<std::uint16_t>(i + 1);
    limits.paper.stretch_factor = 2;
    if (i == 3) limits.quota = 40;
    const PassStatistics s = pass.run(limits, {}, &a);
    b.changed.assign(b.changed.size(), 0);
    b.remembered.assign(b.remembered.size(), 0);
    const PassStatistics t = GreedyPass<double>().run(limits, {}, &b);
    EXPECT_EQ(s.fused, t.fused);
    EXPECT_EQ(s.labelled, t.labelled);
    EXPECT_EQ(s.rejected, t.rejected);
    EXPECT_EQ(a.tets, b.tets);
    EXPECT_EQ(a.point_ids, b.point_ids);
  }
}

TEST(GreedyPass, TheQuotaIsKeptAndSpread) {
  const Geometry g = five_split_cube(16, 0.1);
  WorkMesh<double> mesh = to_work_mesh(g);
  testing::number_tets(&mesh);
  const std::uint64_t before = mesh.tets.size();
  PassLimits limits;
  limits.quota = before / 10;
  const PassStatistics s = GreedyPass<double>().run(limits, {}, &mesh);
  EXPECT_LE(before - s.tets_after, limits.quota);
  EXPECT_GT(before - s.tets_after, limits.quota * 9 / 10);
  // Both halves of the order lose their share.
  const auto numbers = testing::tet_numbers(mesh);
  const auto in_first_half = static_cast<std::uint64_t>(
      std::count_if(numbers.begin(), numbers.end(), [&](TetId t) { return t < before / 2; }));
  EXPECT_NEAR(static_cast<double>(before / 2 - in_first_half),
              static_cast<double>(limits.quota) / 2, 0.1 * static_cast<double>(limits.quota));
}

TEST(GreedyPass, FloatMeshKeepsVolumeAndBoundary) {
  WorkMesh<float> mesh = to_float_work_mesh(five_split_cube(20, 0.2, 3));
  const double volume_before = volume(mesh);
  const auto boundary_before = boundary(mesh);
  const std::size_t before = mesh.tets.size();
  run_until_nothing_fuses(&mesh);
  EXPECT_LT(mesh.tets.size(), before * 7 / 10);
  EXPECT_TRUE(all_positive(mesh));
  EXPECT_NEAR(volume(mesh) / volume_before, 1, 1e-12);
  EXPECT_EQ(boundary(mesh), boundary_before);
}

// A carried cell may need a vertex that a fusion would swallow.
TEST(GreedyPass, DoesNotSwallowALockedVertex) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(12, 0.2, 5));
  for (std::size_t v = 0; v < mesh.vertex_count(); v += 7) mesh.marks[v] |= kLocked;
  std::set<VertexId> locked;
  for (std::size_t v = 0; v < mesh.vertex_count(); v += 7) locked.insert(mesh.point_ids[v]);
  run_until_nothing_fuses(&mesh);
  std::set<VertexId> used;
  for (const Tet& t : mesh.tets) {
    for (const VertexId v : t) used.insert(mesh.point_ids[v]);
  }
  for (const VertexId v : locked) EXPECT_TRUE(used.contains(v)) << v;
}

}  // namespace
}  // namespace tetfusion
