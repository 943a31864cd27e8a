#include "kernel/fit/tet_walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>

#include "kernel/fit/cell_means.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using P = Vec3<double>;

// Two cubes of cells; the second one, so far to the right.
WorkMesh<double> two_cubes(double apart) {
  Geometry both = testing::five_split_cube(6, 0.1, 3);
  const Geometry other = testing::five_split_cube(6, 0.1, 5);
  auto& points = std::get<Vector<P>>(both.points);
  const auto first = static_cast<VertexId>(points.size());
  for (const P& p : std::get<Vector<P>>(other.points)) points.push_back({p.x + apart, p.y, p.z});
  for (const Tet& t : other.tets) {
    both.tets.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  }
  return testing::to_work_mesh(both);
}

TEST(TetWalk, FindsTheCentreOfEachTetrahedron) {
  const WorkMesh<double> mesh = two_cubes(6.5);
  TetWalk<double> walk;
  walk.begin(mesh);
  for (TetId t = 0; t < mesh.tets.size(); ++t) {
    ASSERT_TRUE(walk.find(centre_of(mesh.positions, mesh.tets[t]))) << t;
    EXPECT_EQ(walk.place().tet, t);
  }
  EXPECT_FALSE(walk.find({6.25, 3, 3}));  // between them
}

// A comb whose teeth stand close: a walk often begins in another tooth. All but a few are found.
TEST(TetWalk, FindsWhatIsBetweenCracks) {
  Geometry comb = testing::kuhn_box(16, 4, 24, 0.1, 2);
  auto& points = std::get<Vector<P>>(comb.points);
  const Vector<P> before = points;
  // Each second wall of points is doubled above the first layers: the cells to its right take the
  // copies.
  std::map<VertexId, VertexId> copies;
  const auto wall_of = [&](const P& p) { return std::lround(p.x); };
  for (Tet& tet : comb.tets) {
    double x = 0;
    for (const VertexId v : tet) x += before[v].x / 4;
    for (VertexId& v : tet) {
      const P& p = before[v];
      if (wall_of(p) % 2 == 0 || x < static_cast<double>(wall_of(p)) || p.z < 3.5) continue;
      const auto [at, is_new] = copies.try_emplace(v, static_cast<VertexId>(points.size()));
      if (is_new) points.push_back(p);
      v = at->second;
    }
  }
  const WorkMesh<double> mesh = testing::to_work_mesh(comb);
  TetWalk<double> walk;
  walk.begin(mesh);
  int lost = 0;
  for (std::size_t i = 0; i < 2000; ++i) {
    const auto t =
        static_cast<TetId>(testing::uniform(7, i) * static_cast<double>(mesh.tets.size()));
    lost += walk.find(centre_of(mesh.positions, mesh.tets[t])) ? 0 : 1;
  }
  EXPECT_LT(lost, 10);
  EXPECT_FALSE(walk.leave_out_overlaps());
}

TEST(TetWalk, SeesWhatLiesOverEachOther) {
  for (const auto& [apart, expected] : {std::pair(7.0, false),
                                        {6.0, false},
                                        {5.99, false},
                                        {5.5, true},
                                        {5.0, true},
                                        {1.0, true}}) {
    const WorkMesh<double> mesh = two_cubes(apart);
    TetWalk<double> walk;
    walk.begin(mesh);
    EXPECT_EQ(walk.leave_out_overlaps(), expected) << apart;
  }
}

// Where both are, a place does not say to which a point belongs; elsewhere it does.
TEST(TetWalk, FindsNothingWhereTwoPartsLieOverEachOther) {
  const WorkMesh<double> mesh = two_cubes(4.5);
  TetWalk<double> walk;
  walk.begin(mesh);
  ASSERT_TRUE(walk.leave_out_overlaps());
  int found = 0, left_out = 0;
  for (TetId t = 0; t < mesh.tets.size(); ++t) {
    const P centre = centre_of(mesh.positions, mesh.tets[t]);
    const bool is_in_both = centre.x > 4.5 && centre.x < 6;
    EXPECT_EQ(walk.find(centre), !is_in_both) << centre.x;
    EXPECT_EQ(walk.find_from(centre, centre), !is_in_both) << centre.x;
    if (!is_in_both) {
      EXPECT_EQ(walk.place().tet, t);
    }
    ++(is_in_both ? left_out : found);
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(left_out, 300);
  // Corners belong to many, which touch.
  EXPECT_TRUE(walk.find(mesh.positions[0]));
  walk.begin(mesh);
  EXPECT_TRUE(walk.find({5, 3, 3}));
}

}  // namespace
}  // namespace tetfusion
