#include "kernel/fuse/fuse_cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "kernel/shapes/shape_grades.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::kUnit;

// A ball of twenty tetrahedra round a centre, and one of its neighbours.
class IcosahedronCavity : public ::testing::Test {
 protected:
  IcosahedronCavity() : mesh(testing::to_work_mesh(testing::icosahedron_ball())) {
    while (mesh.incidence[centre] != 20) ++centre;
    partner = centre == 0 ? 1 : 0;
    at = mesh.positions[partner];
    balls.reset(mesh.vertex_count(), mesh.tets);
    cavity.begin(&mesh, &balls, 0.2, kUnit);
  }

  WorkMesh<double> mesh;
  VertexId centre = 0, partner = 0;
  Vec3<double> at{};
  LiveBalls balls;
  FuseCavity<double> cavity;
};

// The centre of an icosahedron may go to a vertex, and near it. From further away it is
// pushed until each of the tetrahedra is content.
TEST_F(IcosahedronCavity, PushesAPositionUntilItIsAllowed) {
  EXPECT_FALSE(cavity.collect(centre, partner, true, at));
  EXPECT_EQ(cavity.deleted().size(), 5u);
  EXPECT_EQ(cavity.affected().size(), 15u);
  for (const double far : {3.0, -2.0}) {
    Vec3<double> position{far * at.x, far * at.y + 0.3, far * at.z};
    int pushes = 0;
    auto reason = cavity.collect(centre, partner, true, position);
    EXPECT_TRUE(reason);
    for (; reason && pushes < 30; ++pushes) {
      const auto [direction, distance] = cavity.obstacle();
      EXPECT_NEAR(dot(direction.data(), direction), 1, 1e-6);
      position.x += double{distance} * direction[0] / kUnit;
      position.y += double{distance} * direction[1] / kUnit;
      position.z += double{distance} * direction[2] / kUnit;
      reason = cavity.collect(centre, partner, true, position);
    }
    EXPECT_FALSE(reason);
  }
}

// What spoke against one pair does not speak against the next when that one is asked again.
TEST_F(IcosahedronCavity, ForgetsAReasonThatIsGone) {
  for (VertexId u = 0; u < mesh.vertex_count(); ++u) {
    if (u == centre) continue;
    EXPECT_TRUE(cavity.collect(centre, partner, true, {-2 * at.x, -2 * at.y, -2 * at.z}));
    if (u == partner) continue;
    EXPECT_FALSE(cavity.collect(centre, u, true, mesh.positions[u]));
    EXPECT_FALSE(cavity.collect(centre, u, true, mesh.positions[u]));
  }
}

struct InMesh {
  explicit InMesh(Geometry geometry) : mesh(testing::to_work_mesh(std::move(geometry))) {
    balls.reset(mesh.vertex_count(), mesh.tets);
    cavity.begin(&mesh, &balls, 0.05, 0x1p-3);
  }
  WorkMesh<double> mesh;
  LiveBalls balls;
  FuseCavity<double> cavity;
};

// What spoke against one edge has nothing to say about another, even where that is asked twice.
TEST(FuseCavity, AnEdgeIsJudgedByItsOwnTetrahedra) {
  InMesh in(testing::five_split_cube(5, 0.1, 2));
  const WorkMesh<double>& mesh = in.mesh;
  FuseCavity<double>& cavity = in.cavity;
  const auto inside = [&](VertexId v) { return (mesh.marks[v] & kOnBoundary) == 0; };
  std::size_t allowed = 0;
  for (const Tet& tet : mesh.tets) {
    const VertexId v = tet[0], partner = tet[1];
    if (!inside(v) || !inside(partner) || !inside(tet[2])) continue;
    ASSERT_TRUE(cavity.collect(tet[2], v, false, {-100, -100, -100}));
    const Vec3<double>&a = mesh.positions[v], &b = mesh.positions[partner];
    const Vec3<double> middle{(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
    if (cavity.collect(v, partner, false, middle)) continue;
    ++allowed;
    const std::vector<std::uint32_t> affected(cavity.affected().begin(), cavity.affected().end());
    const std::vector<TetId> deleted(cavity.deleted().begin(), cavity.deleted().end());
    EXPECT_FALSE(cavity.collect(v, partner, false, middle));
    EXPECT_TRUE(std::equal(affected.begin(), affected.end(), cavity.affected().begin(),
                           cavity.affected().end()));
    EXPECT_TRUE(std::equal(deleted.begin(), deleted.end(), cavity.deleted().begin(),
                           cavity.deleted().end()));
  }
  EXPECT_GT(allowed, 5u);
}

double cubed_mean_ratio(const std::array<Vec3<double>, 4>& p) {
  const auto minus = [](const Vec3<double>& a, const Vec3<double>& b) {
    return Point3{a.x - b.x, a.y - b.y, a.z - b.z};
  };
  double edges = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = i + 1; k < 4; ++k) edges += dot(minus(p[i], p[k]), minus(p[i], p[k]));
  }
  const double det = dot(minus(p[1], p[0]), cross(minus(p[2], p[0]), minus(p[3], p[0])));
  return det < 0 ? det : 432 * det * det / (edges * edges * edges);
}

// On a mesh so flat that many cells are below the floor: what comes is no worse than the floor, or
// than the worst grade that is there, and only a ball that has something below the floor gets more
// of it. Nothing else is refused. Where fusions are done, what is known of balls follows.
TEST(FuseCavity, NothingGetsWorseThanTheWorstGrade) {
  constexpr double kFloor = 0.3;
  Geometry flat = testing::five_split_cube(7, 0.3, 5);
  for (auto& p : std::get<Vector<Vec3<double>>>(flat.points)) p.z *= p.x < 3.5 ? 0.35 : 0.8;
  WorkMesh<double> mesh = testing::to_work_mesh(flat);
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  FuseCavity<double> cavity;
  cavity.begin(&mesh, &balls, kFloor, 0x1p-3);
  const double floor = kFloor * kFloor * kFloor;
  const auto shape_of = [&](const Tet& tet) {
    return cubed_mean_ratio({mesh.positions[tet[0]], mesh.positions[tet[1]], mesh.positions[tet[2]],
                             mesh.positions[tet[3]]});
  };
  const ShapeGrades grades(kFloor);
  std::vector<std::uint8_t> grade_of;  // of tetrahedra
  for (const Tet& tet : mesh.tets) grade_of.push_back(grades.grade_of(shape_of(tet)));
  struct Ball {
    double now = 1, then = 1;  // the worst
    std::uint8_t grade = 0;
  };
  const auto look = [&](VertexId v, VertexId partner, const Vec3<double>& position) {
    Ball ball;
    for (const Tet& tet : mesh.tets) {
      if (is_deleted(tet) || std::ranges::count(tet, v) == 0) continue;
      ball.now = std::min(ball.now, shape_of(tet));
      ball.grade =
          std::max(ball.grade, grade_of[static_cast<std::size_t>(&tet - mesh.tets.data())]);
      if (std::ranges::count(tet, partner) != 0) continue;
      std::array<Vec3<double>, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = tet[i] == v ? position : mesh.positions[tet[i]];
      }
      ball.then = std::min(ball.then, cubed_mean_ratio(corners));
    }
    return ball;
  };
  std::mt19937 random(1);
  int allowed = 0, refused = 0, below = 0, fused = 0;
  for (int i = 0; i < 1500; ++i) {
    const Tet tet = mesh.tets[random() % mesh.tets.size()];
    const VertexId v = tet[0], partner = tet[1];
    if (is_deleted(tet)) continue;
    if (((mesh.marks[v] | mesh.marks[partner]) & kOnBoundary) != 0) continue;
    const double share = 0.25 * static_cast<double>(random() % 5);
    const Vec3<double>&a = mesh.positions[v], &b = mesh.positions[partner];
    const Vec3<double> at{a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
                          a.z + share * (b.z - a.z)};
    const Ball one = look(v, partner, at), other = look(partner, v, at);
    const std::uint8_t grade = std::max(one.grade, other.grade);
    bool expected = true, is_close = false;
    for (const Ball& ball : {one, other}) {
      const double limit = ball.now < floor ? grades.least(grade) : floor;
      expected = expected && ball.then >= limit;
      is_close = is_close || std::abs(ball.then - limit) < 1e-6 * limit;
    }
    const auto reason = cavity.collect(v, partner, false, at);
    ASSERT_TRUE(is_close || !reason == expected) << i;
    (reason ? refused : allowed) += 1;
    if (reason) continue;
    below += std::min(one.then, other.then) < floor ? 1 : 0;
    if (fused == 30) continue;
    ++fused;
    const VertexId kept = std::min(v, partner), gone = std::max(v, partner);
    const std::vector<std::uint32_t> affected(cavity.affected().begin(), cavity.affected().end());
    for (const TetId t : cavity.deleted()) {
      for (const VertexId u : mesh.tets[t]) --mesh.incidence[u];
      mark_deleted(&mesh.tets[t]);
    }
    for (const std::uint32_t entry : affected) mesh.tets[entry >> 2][entry & 3u] = kept;
    for (const VertexId u : {gone, kept}) {
      mesh.incidence[u] = 0;
      balls.clear(u);
    }
    balls.add(kept, affected);
    mesh.incidence[kept] = static_cast<std::uint32_t>(affected.size());
    mesh.positions[kept] = at;
    cavity.note_fused(kept);
    for (const std::uint32_t entry : affected) {
      const std::uint8_t own = grades.grade_of(shape_of(mesh.tets[entry >> 2]));
      ASSERT_LE(grades.least(grade), shape_of(mesh.tets[entry >> 2]) * (1 + 1e-6));
      std::uint8_t& noted = grade_of[entry >> 2];
      noted = std::max(noted, std::min(own, grade));
    }
  }
  EXPECT_GT(allowed, 50);
  EXPECT_GT(refused, 50);
  EXPECT_GT(below, 20);
}

// Where the two were is in the new mesh, in a tetrahedron that the new vertex has.
TEST(FuseCavity, KnowsWhereTheTwoWouldBe) {
  InMesh in(testing::five_split_cube(6, 0.3, 4));
  const WorkMesh<double>& mesh = in.mesh;
  FuseCavity<double>& cavity = in.cavity;
  std::size_t allowed = 0;
  for (const Tet& tet : mesh.tets) {
    const VertexId v = tet[0], partner = tet[1];
    if (((mesh.marks[v] | mesh.marks[partner]) & kOnBoundary) != 0) continue;
    const Vec3<double>&a = mesh.positions[v], &b = mesh.positions[partner];
    const Vec3<double> at{(a.x + 2 * b.x) / 3 + 0.1, (a.y + 2 * b.y) / 3, (a.z + 2 * b.z) / 3};
    if (cavity.collect(v, partner, false, at)) continue;
    ++allowed;
    const auto expect_at = [&](const FuseCavity<double>::Place& place, const Vec3<double>& x) {
      Vec3<double> found{place.shares[0] * at.x, place.shares[0] * at.y, place.shares[0] * at.z};
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3<double>& p = mesh.positions[place.base[i]];
        const double share = place.shares[i + 1];
        found = {found.x + share * p.x, found.y + share * p.y, found.z + share * p.z};
      }
      EXPECT_NEAR(found.x, x.x, 1e-9);
      EXPECT_NEAR(found.y, x.y, 1e-9);
      EXPECT_NEAR(found.z, x.z, 1e-9);
      const auto has_base = [&](std::uint32_t entry) {
        const Tet& t = mesh.tets[entry >> 2];
        return std::all_of(place.base.begin(), place.base.end(), [&](VertexId u) {
          return u != t[entry & 3u] && std::find(t.begin(), t.end(), u) != t.end();
        });
      };
      EXPECT_TRUE(std::any_of(cavity.affected().begin(), cavity.affected().end(), has_base));
    };
    for (const VertexId u : {v, partner}) {
      const Vec3<double>& x = mesh.positions[u];
      const auto place = u == v ? cavity.place_of_vertex() : cavity.place_of_partner();
      expect_at(place, x);
      EXPECT_GE(place.least(), -1e-9);
    }
  }
  EXPECT_GT(allowed, 50u);
}

}  // namespace
}  // namespace tetfusion
