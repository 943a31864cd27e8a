#include "mesh/inspection/boundary_sample.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mesh/inspection/inspect.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_box;

BoundarySample sample_of(const Geometry& mesh, std::uint64_t vertices) {
  BoundarySample sample(point_count(mesh.points), vertices);
  // In two parts, as windows come.
  const std::span<const Tet> tets = mesh.tets;
  const std::size_t half = tets.size() / 3;
  sample.add(tets.subspan(half));
  sample.add(tets.first(half));
  return sample;
}

TEST(BoundarySample, OfAllVerticesIsExact) {
  for (const Geometry& mesh :
       {five_split_box(1, 1, 1), five_split_box(4, 3, 5), five_split_box(9, 9, 9),
        testing::single_tet(), testing::icosahedron_ball(), testing::plate(4)}) {
    Geometry copy = mesh;
    const Inspection inspection = inspect(copy);
    const auto on_boundary =
        std::count_if(inspection.vertex_flags.begin(), inspection.vertex_flags.end(),
                      [](std::uint8_t flags) { return (flags & kBoundaryVertex) != 0; });
    const BoundarySample sample = sample_of(mesh, BoundarySample::kVertices);
    const std::uint64_t points = point_count(mesh.points);
    EXPECT_EQ(sample.used_points(), points);
    EXPECT_EQ(sample.tets(), mesh.tets.size());
    EXPECT_DOUBLE_EQ(sample.boundary_share(),
                     static_cast<double>(on_boundary) / static_cast<double>(points));
  }
}

TEST(BoundarySample, OfSomeVerticesIsNear) {
  const Geometry mesh = five_split_box(30, 30, 30);
  const double exact = 1 - 29.0 * 29 * 29 / (31.0 * 31 * 31);
  for (const std::uint64_t vertices : {2000, 5000}) {
    const BoundarySample sample = sample_of(mesh, vertices);
    EXPECT_NEAR(sample.boundary_share(), exact, 0.03);
    EXPECT_NEAR(static_cast<double>(sample.used_points()), 31.0 * 31 * 31, 100);
  }
}

TEST(BoundarySample, LeavesOutPointsOfNoTetrahedron) {
  Geometry mesh = five_split_box(3, 3, 3);
  const std::uint64_t used = point_count(mesh.points);
  std::get<Vector<Vec3<double>>>(mesh.points).resize(3 * used);
  const BoundarySample sample = sample_of(mesh, BoundarySample::kVertices);
  EXPECT_EQ(sample.used_points(), used);
  EXPECT_DOUBLE_EQ(sample.boundary_share(), 56.0 / 64);
  EXPECT_EQ(BoundarySample(0).boundary_share(), 0);
  EXPECT_EQ(BoundarySample(0).used_points(), 0u);
}

}  // namespace
}  // namespace tetfusion
