// What holds a round back: error, quota, shape, marks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "kernel/fuse/fuse_round.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "mesh/quality.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::expect_same_domain;
using testing::five_split_cube;
using testing::kuhn_box;
using testing::kUnit;
using testing::limits_of;
using testing::linear;
using testing::rejected;
using testing::rough;
using testing::run;
using testing::smooth;
using testing::Steered;
using testing::steered;
using testing::uniform;

template <class Real>
double quality(const WorkMesh<Real>& mesh, const Tet& t) {
  const auto& p = mesh.positions;
  return measure_shape(p[t[0]], p[t[1]], p[t[2]], p[t[3]]).mean_ratio;
}

template <class Real>
double worst_quality(const WorkMesh<Real>& mesh) {
  double worst = 1;
  for (const Tet& t : mesh.tets) worst = std::min(worst, quality(mesh, t));
  return worst;
}

TEST(FuseLimits, NothingFusesForNothing) {
  Steered s = steered(five_split_cube(7, 0.2, 6), linear);
  EXPECT_EQ(run(limits_of(0), &s).pass.fused, 0u);
  // Where the fields allow all, length alone costs: a millionth of its square, as a share of the
  // mesh.
  EXPECT_GT(run(limits_of(1e-7), &s).pass.fused, 100u);
}

TEST(FuseLimits, ARoughFieldHoldsBack) {
  Steered s = steered(five_split_cube(7, 0.2, 6), rough);
  const FuseStatistics statistics = run(limits_of(1e-6), &s);
  EXPECT_EQ(statistics.pass.fused, 0u);
  EXPECT_EQ(rejected(statistics, Reject::kError), 6u * 6 * 6);
  EXPECT_EQ(std::accumulate(statistics.costs.begin(), statistics.costs.end(), 0ULL), 6u * 6 * 6);
}

// The mean of the squares that each quadric gives its own vertex is what its last fusion cost.
TEST(FuseLimits, NoFusionCostsMoreThanTheThreshold) {
  for (const auto f : {smooth, rough}) {
    const Steered fresh = steered(five_split_cube(8, 0.2, 8), f);
    for (const double least : {1e-5, 1e-4, 1e-2}) {
      for (double threshold = least; threshold < 2 * least; threshold *= 1.17) {
        Steered s = fresh;
        const FuseStatistics statistics = run(limits_of(threshold), &s);
        EXPECT_GT(rejected(statistics, Reject::kError) + statistics.pass.fused, 300u);
        for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
          const float* q = s.mesh.quadrics.data() + v * s.mesh.quadric_width;
          EXPECT_LE(q[kQuadricC] / q[kQuadricW], threshold * (1 + 1e-4) + 1e-8);
        }
      }
    }
  }
}

TEST(FuseLimits, TheQuotaIsNeverExceeded) {
  const Steered fresh = steered(five_split_cube(8, 0.2, 6), smooth);
  for (const std::uint64_t quota : {0, 1, 3, 4, 5, 6, 17, 50, 400, 1000}) {
    Steered s = fresh;
    FuseLimits limits = limits_of();
    limits.quota = quota;
    const FuseStatistics statistics = run(limits, &s);
    const std::uint64_t removed = statistics.pass.tets_before - statistics.pass.tets_after;
    EXPECT_LE(removed, quota);
    EXPECT_GT(removed + 12, quota);
    EXPECT_GT(rejected(statistics, Reject::kQuota), 0u) << quota;
    expect_same_domain(s.mesh, fresh.mesh);
  }
}

TEST(FuseLimits, NoTetrahedronGetsBelowTheFloor) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const double floor : {0.0, 0.1, 0.3, 0.6, 0.99}) {
      Steered s = steered(five_split_cube(9, 0.2, seed), smooth);
      const WorkMesh<double> before = s.mesh;
      FuseLimits limits = limits_of();
      limits.min_quality = floor;
      const FuseStatistics statistics = run(limits, &s);
      const std::uint64_t refused = rejected(statistics, Reject::kQuality);
      EXPECT_TRUE(floor == 0 ? refused == 0 : refused > 0 || floor < 0.2);
      EXPECT_GE(worst_quality(s.mesh), std::min(floor, worst_quality(before)) - 1e-12);
      expect_same_domain(s.mesh, before);
    }
  }
}

// Cubes with six layers a thousand times as flat below them.
Geometry boundary_layer(double jitter) {
  Geometry g = kuhn_box(8, 8, 12, jitter, 3);
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    const double layer = std::round(p.z);
    p.z = layer <= 6 ? 1e-3 * layer : 6e-3 + (layer - 6);
  }
  return g;
}

// A floor that the whole mesh is below lets nothing get worse than that, but for a twentieth.
TEST(FuseLimits, ABoundaryLayerGetsHardlyWorse) {
  const Geometry g = boundary_layer(0.1);
  Steered s = steered(g, smooth);
  const WorkMesh<double> before = s.mesh;
  ASSERT_TRUE(testing::all_positive(before));
  const double worst = worst_quality(before);
  ASSERT_LT(worst, 0.02);
  for (const double floor : {0.0, 0.2}) {
    s.mesh = before;
    FuseLimits limits = limits_of();
    limits.min_quality = floor;
    const FuseStatistics statistics = run(limits, &s);
    EXPECT_GT(statistics.pass.fused, 50u);
    expect_same_domain(s.mesh, before);
    if (floor > 0) {
      EXPECT_GE(worst_quality(s.mesh), 0.95 * worst);
    }
  }
}

// Layers of equal cells, each as bad as any other: they go, and however often something fuses there
// it is no worse than they were, but for a twentieth.
TEST(FuseLimits, EvenLayersAreNeitherFrozenNorWrecked) {
  Steered s = steered(boundary_layer(0), linear);
  const double worst = worst_quality(s.mesh);
  const std::size_t before = s.mesh.tets.size();
  ASSERT_LT(worst, 0.02);
  for (int round = 0; round < 10; ++round) run(limits_of(), &s);
  EXPECT_GE(worst_quality(s.mesh), 0.95 * worst);
  EXPECT_LT(s.mesh.tets.size(), before / 3);
}

TEST(FuseLimits, EveryReasonIsCounted) {
  std::array<std::uint64_t, kRejectReasons> all{};
  for (const double threshold : {1e-3, 1.0}) {
    for (const std::uint64_t quota : {100u, 1'000'000u}) {
      Steered s = steered(five_split_cube(9, 0.2, 4), smooth);
      for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
        if (uniform(4, v) < 0.05) s.mesh.marks[v] |= v % 2 == 0 ? kLocked : (kOnInterface | kLast);
      }
      FuseLimits limits = limits_of(threshold);
      limits.quota = quota;
      for (const double floor : {0.0, 0.6}) {
        limits.min_quality = floor;
        const FuseStatistics statistics = run(limits, &s);
        for (std::size_t r = 0; r < kRejectReasons; ++r) all[r] += statistics.pass.rejected[r];
      }
    }
  }
  for (const Reject r : {Reject::kBoundary, Reject::kLocked, Reject::kInterface, Reject::kFlip,
                         Reject::kQuality, Reject::kError, Reject::kQuota}) {
    EXPECT_GT(all[static_cast<std::size_t>(r)], 0u) << kRejectNames[static_cast<std::size_t>(r)];
  }
  for (const Reject r : {Reject::kScalar, Reject::kStretch, Reject::kAspect}) {
    EXPECT_EQ(all[static_cast<std::size_t>(r)], 0u);
  }
}

}  // namespace
}  // namespace tetfusion
