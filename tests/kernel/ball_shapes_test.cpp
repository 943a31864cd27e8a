#include "kernel/shapes/ball_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/live_balls.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using Point = std::array<long double, 3>;

// The cubed mean ratio over 432, with the sign of the volume.
long double exact_shape(const std::array<Point, 4>& p) {
  std::array<Point, 3> e{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t a = 0; a < 3; ++a) e[i][a] = p[i + 1][a] - p[0][a];
  }
  const long double det = e[2][0] * (e[0][1] * e[1][2] - e[0][2] * e[1][1]) +
                          e[2][1] * (e[0][2] * e[1][0] - e[0][0] * e[1][2]) +
                          e[2][2] * (e[0][0] * e[1][1] - e[0][1] * e[1][0]);
  long double edges = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      for (std::size_t a = 0; a < 3; ++a) {
        edges += (p[j][a] - p[i][a]) * (p[j][a] - p[i][a]);
      }
    }
  }
  return std::copysign(det * det / (edges * edges * edges), det);
}

struct Counts {
  std::size_t good = 0, bad = 0, doubtful = 0;
};

template <class Real>
void gather(const WorkMesh<Real>& mesh, const GridPositions<Real>& grid, VertexId v,
            std::span<const std::uint32_t> ball, BallShapes<Real>* shapes) {
  shapes->begin(mesh, grid, v, ball);
  for (std::size_t first = 0; first < ball.size(); first += kLanes) shapes->gather(first);
}

bool has(const Tet& tet, VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); }

// Judges places near each vertex and far from it, and holds each verdict against the exact shape.
template <class Real>
Counts judge_places(const WorkMesh<Real>& mesh, const ShapeFloors& floors, unsigned seed) {
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  GridPositions<Real> grid;
  grid.reset(mesh.positions);
  BallShapes<Real> shapes;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1.5, 1.5);
  Counts counts;
  const auto point = [](const Vec3<Real>& p) { return Point{p.x, p.y, p.z}; };
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    const auto ball = balls.of(v, mesh.incidence[v], mesh.tets);
    gather(mesh, grid, v, ball, &shapes);
    EXPECT_EQ(shapes.vertex(), v);
    const Tet& some = mesh.tets[ball[v % ball.size()] >> 2];
    for (const VertexId u : some) {
      if (u == v) continue;
      const Vec3<Real>&a = mesh.positions[v], &b = mesh.positions[u];
      const double x = share(random), y = share(random), z = share(random);
      const Vec3<Real> to{static_cast<Real>(a.x + x * (b.x - a.x)),
                          static_cast<Real>(a.y + y * (b.y - a.y)),
                          static_cast<Real>(a.z + z * (b.z - a.z))};
      const auto local = shapes.local(to);
      for (std::size_t i = 0; i < ball.size(); ++i) {
        const std::size_t first = i / kLanes * kLanes, lane = i % kLanes;
        const bool good = shapes.good(first, local, u, floors)[lane] != 0;
        const bool bad = shapes.bad(first, local, floors)[lane] != 0;
        const Tet& tet = mesh.tets[ball[i] >> 2];
        if (has(tet, u)) {
          EXPECT_TRUE(good);
          continue;
        }
        std::array<Point, 4> p{};
        for (std::size_t c = 0; c < 4; ++c) p[c] = point(mesh.positions[tet[c]]);
        p[ball[i] & 3u] = point(to);
        const long double shape = exact_shape(p);
        if (good) {
          EXPECT_GE(shape, static_cast<long double>(floors.sure) * (1 - 1e-6L));
          EXPECT_FALSE(bad);
          ++counts.good;
        } else if (bad) {
          EXPECT_LE(shape, static_cast<long double>(floors.floor) * (1 + 1e-6L));
          ++counts.bad;
        } else {
          ++counts.doubtful;
        }
      }
    }
  }
  return counts;
}

template <class Real>
WorkMesh<Real> moved(const WorkMesh<double>& from, const std::array<double, 3>& scale,
                     double offset) {
  WorkMesh<Real> mesh;
  mesh.tets = from.tets;
  mesh.incidence = from.incidence;
  for (const Vec3<double>& p : from.positions) {
    mesh.positions.push_back({static_cast<Real>(offset + scale[0] * p.x),
                              static_cast<Real>(offset + scale[1] * p.y),
                              static_cast<Real>(offset + scale[2] * p.z)});
  }
  return mesh;
}

// Mean ratios of 0.22 and 0.22, and of 0.001 and none.
const std::vector<ShapeFloors> kFloors{{2.465e-5F, 2.464e-5F}, {2.32e-12F, 0}};

TEST(BallShapes, VerdictsHoldAndFewAreDoubtful) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(6, 0.3, 4));
  for (const ShapeFloors& floors : kFloors) {
    for (const double scale : {1.0, 0x1p-300, 0x1p300}) {
      const Counts counts = judge_places(moved<double>(mesh, {scale, scale, scale}, 0), floors, 1);
      EXPECT_GT(counts.good, 1000u);
      EXPECT_GT(counts.bad, 300u);
      EXPECT_LT(counts.doubtful, 20u);
    }
    const Counts single = judge_places(moved<float>(mesh, {1, 1, 1}, 100), floors, 2);
    EXPECT_LT(single.doubtful, 20u);
  }
}

// A boundary layer, and meshes so far from the origin, or so flat, that little is left of their
// coordinates.
TEST(BallShapes, VerdictsHoldWhereShapesAreExtreme) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(5, 0.3, 7));
  for (const ShapeFloors& floors : kFloors) {
    for (const double thin : {1e-3, 1e-6, 1e-9}) {
      judge_places(moved<double>(mesh, {1, 1, thin}, 0), floors, 3);
      judge_places(moved<double>(mesh, {thin, 1, thin}, 0), floors, 4);
      judge_places(moved<float>(mesh, {1, thin, 1}, 0), floors, 5);
    }
    judge_places(moved<double>(mesh, {1, 1, 1}, 1e9), floors, 6);
    judge_places(moved<float>(mesh, {1, 1, 1}, 1e5), floors, 7);
  }
}

// The scale is that of one neighbour: where it is far nearer than the others, cubes of their edges
// are beyond what single precision holds.
TEST(BallShapes, VerdictsHoldWhereOneNeighbourIsNear) {
  const WorkMesh<double> base = testing::to_work_mesh(testing::five_split_cube(4, 0.3, 7));
  for (int e = -30; e <= -10; ++e) {
    WorkMesh<double> mesh = moved<double>(base, {1, 1, 1}, 0);
    for (VertexId v = 0; v < mesh.vertex_count(); v += 7) {  // near to one of its neighbours
      const auto tet = std::ranges::find_if(mesh.tets, [&](const Tet& t) { return has(t, v); });
      const VertexId u = (*tet)[0] == v ? (*tet)[1] : (*tet)[0];
      const Vec3<double>&a = mesh.positions[u], &b = base.positions[v];
      const double share = std::ldexp(1.0, e);
      mesh.positions[v] = {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
                           a.z + share * (b.z - a.z)};
    }
    for (const ShapeFloors& floors : kFloors) judge_places(mesh, floors, 8);
  }
}

// One end of the mesh is as fine as a unit of the grid: nothing is certain there.
TEST(BallShapes, AGridThatIsTooCoarseLeavesDoubts) {
  WorkMesh<double> mesh =
      moved<double>(testing::to_work_mesh(testing::five_split_cube(5, 0.3, 7)), {1, 1, 1}, 0);
  mesh.positions.push_back({4e9, 0, 0});
  mesh.incidence.push_back(0);
  GridPositions<double> grid;
  grid.reset(mesh.positions);
  EXPECT_TRUE(grid.holds());
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  BallShapes<double> shapes;
  for (VertexId v = 0; v + 1 < mesh.vertex_count(); ++v) {
    gather(mesh, grid, v, balls.of(v, mesh.incidence[v], mesh.tets), &shapes);
    EXPECT_TRUE(shapes.may_have_bad(kFloors[0]));
    const auto local = shapes.local(mesh.positions[v]);
    const LaneMask good = shapes.good(0, local, kNoVertex, kFloors[0]);
    const LaneMask bad = shapes.bad(0, local, kFloors[0]);
    for (std::size_t i = 0; i < kLanes; ++i) {
      EXPECT_EQ(good[i], 0);
      EXPECT_EQ(bad[i], 0);
    }
  }
}

TEST(BallShapes, ListsWhatHasAVertexAndWhatHasNot) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(4, 0.3, 7));
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  GridPositions<double> grid;
  grid.reset(mesh.positions);
  BallShapes<double> shapes;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    const auto ball = balls.of(v, mesh.incidence[v], mesh.tets);
    gather(mesh, grid, v, ball, &shapes);
    for (const VertexId u : mesh.tets[ball[0] >> 2]) {
      Vector<std::uint32_t> without{99}, wanted_without{99};  // what is there stays
      Vector<TetId> with{77}, wanted_with{77};
      for (const std::uint32_t entry : ball) {
        if (has(mesh.tets[entry >> 2], u)) {
          wanted_with.push_back(entry >> 2);
        } else {
          wanted_without.push_back(entry);
        }
      }
      shapes.list(u, &without, &with);
      EXPECT_EQ(without, wanted_without);
      EXPECT_EQ(with, wanted_with);
    }
  }
}

// Moved to a position nearby, a vertex leaves its old position in one of its tetrahedra, as they
// are then.
TEST(BallShapes, FindsTheTetrahedronThatAVertexWasIn) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(4, 0.2, 7));
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  GridPositions<double> grid;
  grid.reset(mesh.positions);
  BallShapes<double> shapes;
  const auto point = [&](VertexId v) {
    const Vec3<double>& p = mesh.positions[v];
    return Point{p.x, p.y, p.z};
  };
  const VertexId inside = 2 * 25 + 2 * 5 + 2;
  const auto ball = balls.of(inside, mesh.incidence[inside], mesh.tets);
  gather(mesh, grid, inside, ball, &shapes);
  const Point old = point(inside);
  std::size_t found_none = 0;
  for (const VertexId u : {inside - 1, inside + 1, inside - 5, inside + 5}) {
    const Vec3<double>&a = mesh.positions[inside], &b = mesh.positions[u];
    const Vec3<double> to{a.x + 0.1 * (b.x - a.x), a.y + 0.1 * (b.y - a.y),
                          a.z + 0.1 * (b.z - a.z)};
    const auto entry = shapes.entry_of_vertex(shapes.local(to), u);
    const auto any = shapes.entry_of_vertex(shapes.local(to), kNoVertex);
    ASSERT_TRUE(any.has_value());
    found_none += entry ? 0 : 1;
    EXPECT_FALSE(entry && has(mesh.tets[*entry >> 2], u));
    // The old position is on the inner side of each of the moved tetrahedron's faces.
    const Tet& tet = mesh.tets[*any >> 2];
    std::array<Point, 4> moved{};
    for (std::size_t c = 0; c < 4; ++c) moved[c] = point(tet[c]);
    moved[*any & 3u] = {to.x, to.y, to.z};
    for (std::size_t c = 0; c < 4; ++c) {
      std::array<Point, 4> part = moved;
      part[c] = old;
      EXPECT_GE(exact_shape(part), -1e-9L);
    }
  }
  EXPECT_LT(found_none, 4u);
}

TEST(BallShapes, APositionOffTheGridLeavesDoubts) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(3, 0.1, 7));
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  GridPositions<double> grid;
  grid.reset(mesh.positions);
  BallShapes<double> shapes;
  const auto ball = balls.of(21, mesh.incidence[21], mesh.tets);
  gather(mesh, grid, 21, ball, &shapes);
  EXPECT_FALSE(shapes.may_have_bad(kFloors[0]));
  grid.move(0, {1e3, 0, 0});
  EXPECT_FALSE(grid.holds());
  gather(mesh, grid, 21, ball, &shapes);
  EXPECT_TRUE(shapes.may_have_bad(kFloors[0]));
}

}  // namespace
}  // namespace tetfusion
