// What is left of a part of a mesh, told away from its cut.
#include "driver/remainder.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

// A unit cube that was cut out of a mesh at x = 0.
WorkMesh<double> part(std::uint32_t cubes) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(cubes));
  double width = 0;
  for (const Vec3<double>& p : mesh.positions) width = std::max(width, p.x);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    Vec3<double>& p = mesh.positions[v];
    p = {p.x / width, p.y / width, p.z / width};
    if (p.x == 0) mesh.marks[v] = kOnInterface;
  }
  return mesh;
}

double boundary_vertices(const WorkMesh<double>& mesh) {
  double count = 0;
  for (const std::uint8_t marks : mesh.marks) count += (marks & kOnBoundary) != 0 ? 1 : 0;
  return count;
}

TEST(Remainder, IsAllWhereNothingFused) {
  const WorkMesh<double> mesh = part(12);
  const Remainder<double> remainder(mesh);
  for (const double tets : {1e4, 1e6}) {
    const double share = remainder.of_mesh(mesh, tets, boundary_vertices(mesh)) / tets;
    EXPECT_NEAR(share, 1, 1e-12);
  }
}

TEST(Remainder, IsAsCoarseAsThePart) {
  const WorkMesh<double> mesh = part(12), left = part(4);
  const auto tets = static_cast<double>(mesh.tets.size());
  const Remainder<double> remainder(mesh);
  for (const double times : {1, 8}) {
    const double share = remainder.of_mesh(left, times * tets, times * boundary_vertices(mesh)) /
                         (times * static_cast<double>(left.tets.size()));
    EXPECT_NEAR(share, 1, 0.15);
  }
}

TEST(Remainder, IsNotWhatTheCutKeeps) {
  const WorkMesh<double> mesh = part(12);
  WorkMesh<double> left = part(4);
  const Remainder<double> remainder(mesh);
  const auto tets = static_cast<double>(mesh.tets.size());
  const double without = remainder.of_mesh(left, tets, boundary_vertices(mesh));
  const auto first = static_cast<VertexId>(left.vertex_count());
  left.positions.insert(left.positions.end(), mesh.positions.begin(), mesh.positions.end());
  left.marks.insert(left.marks.end(), mesh.marks.begin(), mesh.marks.end());
  Vector<Tet> kept;
  for (const Tet& t : mesh.tets) {
    const bool near =
        std::all_of(t.begin(), t.end(), [&](VertexId v) { return mesh.positions[v].x < 0.2; });
    if (near) kept.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  }
  left.tets.insert(left.tets.begin(), kept.begin(), kept.end());
  EXPECT_GT(static_cast<double>(left.tets.size()), 4 * without);
  EXPECT_NEAR(remainder.of_mesh(left, tets, boundary_vertices(mesh)) / without, 1, 0.3);
}

TEST(Remainder, OfNothingIsTheMesh) {
  const WorkMesh<double> none;
  EXPECT_EQ(Remainder<double>(none).of_mesh(none, 100, 10), 100);
}

}  // namespace
}  // namespace tetfusion
