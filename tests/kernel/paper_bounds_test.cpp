#include "kernel/paper_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_cube;
using testing::limits_of;
using testing::linear;
using testing::rejected;
using testing::run;
using testing::smooth;
using testing::Steered;
using testing::steered;

std::array<Vec3<double>, 4> corners(const WorkMesh<double>& mesh, const Tet& t) {
  const auto& p = mesh.positions;
  return {p[t[0]], p[t[1]], p[t[2]], p[t[3]]};
}

TEST(PaperBounds, NoTetrahedronExceedsTheAspectRatioUnlessOneDid) {
  const auto worst = [](const WorkMesh<double>& mesh) {
    double most = 0;
    for (const Tet& t : mesh.tets) {
      most = std::max(most, std::sqrt(edge_ratio_squared(corners(mesh, t))));
    }
    return most;
  };
  Steered s = steered(five_split_cube(9, 0.1, 3), smooth);
  Steered free = s;
  const double before = worst(s.mesh);
  run(limits_of(), &free);
  FuseLimits limits = limits_of();
  limits.paper.aspect_ratio = before + 0.2;
  EXPECT_GT(worst(free.mesh), before + 0.2);
  const FuseStatistics statistics = run(limits, &s);
  EXPECT_GT(statistics.pass.fused, 10u);
  EXPECT_GT(rejected(statistics, Reject::kAspect), 0u);
  EXPECT_LE(worst(s.mesh), before + 0.2);
  testing::expect_whole(s.mesh);
}

TEST(PaperBounds, NoTetrahedronGrowsBeyondTheVolume) {
  const auto volume = [](const WorkMesh<double>& mesh, const Tet& t) {
    const auto p = corners(mesh, t);
    return determinant(p[0], p[1], p[2], p[3]).value / 6;
  };
  const auto largest = [&](const WorkMesh<double>& mesh) {
    double most = 0;
    for (const Tet& t : mesh.tets) most = std::max(most, volume(mesh, t));
    return most;
  };
  Steered s = steered(five_split_cube(9, 0.1, 3), smooth);
  Steered free = s;
  const double before = largest(s.mesh);
  run(limits_of(), &free);
  EXPECT_GT(largest(free.mesh), 2 * before);
  FuseLimits limits = limits_of();
  Steered small = s;
  limits.paper.max_volume = 0.5 * before;
  // Those that are larger may only shrink.
  run(limits, &small);
  EXPECT_LE(largest(small.mesh), before);
  limits.paper.max_volume = 1.5 * before;
  const FuseStatistics statistics = run(limits, &s);
  EXPECT_GT(statistics.pass.fused, 10u);
  EXPECT_GT(rejected(statistics, Reject::kVolume), 0u);
  EXPECT_LE(largest(s.mesh), 1.5 * before);
  EXPECT_GT(largest(s.mesh), before);
  testing::expect_whole(s.mesh);
}

// A field that is the place itself: in one fusion nothing moves further than the tolerance.
TEST(PaperBounds, ValuesStayNearThoseOfTheFused) {
  Steered s = steered(five_split_cube(9, 0.2, 5), linear);
  FuseLimits limits = limits_of();
  limits.paper.scalar_tolerance = 1e-6;
  FuseStatistics statistics = run(limits, &s);
  EXPECT_EQ(statistics.pass.fused, 0u);
  EXPECT_GT(rejected(statistics, Reject::kScalar), 100u);
  limits.paper.scalar_tolerance = 0.05;
  statistics = run(limits, &s);
  EXPECT_GT(statistics.pass.fused, 50u);
}

// Numbers lead back to where each tetrahedron's corners were.
TEST(PaperBounds, BaseNormalsStretchByTheFactorAtMost) {
  for (const double factor : {1.5, 3.0}) {
    Steered s = steered(five_split_cube(9, 0.2, 7), smooth);
    testing::number_tets(&s.mesh);
    const WorkMesh<double> before = s.mesh;
    FuseLimits limits = limits_of();
    limits.paper.stretch_factor = factor;
    const FuseStatistics statistics = run(limits, &s);
    EXPECT_GT(statistics.pass.fused, 20u);
    EXPECT_GT(rejected(statistics, Reject::kStretch), 0u);
    const auto numbers = testing::tet_numbers(s.mesh);
    for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
      const auto then = corners(before, before.tets[numbers[t]]);
      const auto now = corners(s.mesh, s.mesh.tets[t]);
      for (int c = 0; c < 4; ++c) {
        const auto i = static_cast<std::size_t>(c);
        if (then[i].x == now[i].x && then[i].y == now[i].y && then[i].z == now[i].z) continue;
        EXPECT_FALSE(stretches(then, now, c, factor * (1 + 1e-12)));
      }
    }
  }
}

}  // namespace
}  // namespace tetfusion
