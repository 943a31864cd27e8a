// Points of the original that come to lie outside: what is nearest to them, and the bounds there.
#include "kernel/sheets/near_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernel/fuse/fuse_cavity.h"
#include "kernel/fuse/fuse_round.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "kernel/sheets/sheets.h"
#include "support/fuse_meshes.h"
#include "support/outside_deviation.h"
#include "support/surfaces.h"

namespace tetfusion {
namespace {

using testing::five_split_box;
using testing::kUnit;
using testing::rejected;
using testing::Steered;
using testing::SurfaceTriangle;
using testing::uniform;

constexpr std::array<Point3, 3> kCorner{Point3{0, 0, 0}, Point3{2, 0, 0}, Point3{0, 2, 0}};

void expect_at(const Point3& x, const Point3& at) {
  const NearestOnTriangle3 found = nearest_on(x, kCorner);
  EXPECT_EQ(found.at, at);
  EXPECT_EQ(found.squared, dot(minus(x, at), minus(x, at)));
  EXPECT_EQ(found.weights[1], at[0] / 2);
  EXPECT_EQ(found.weights[2], at[1] / 2);
}

TEST(NearestOnTriangle, IsInsideOnAnEdgeOrACorner) {
  expect_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  expect_at({1, -2, 1}, {1, 0, 0});
  expect_at({2, 2, 1}, {1, 1, 0});
  expect_at({-1, -1, -1}, {0, 0, 0});
  expect_at({5, -1, 0}, {2, 0, 0});
}

// A flat one has edges, too.
TEST(NearestOnTriangle, NeedsNoArea) {
  const NearestOnTriangle3 found = nearest_on({1, 1, 0}, {{{0, 0, 0}, {4, 0, 0}, {2, 0, 0}}});
  EXPECT_EQ(found.at, (Point3{1, 0, 0}));
}

TEST(NearestOnTriangle, NothingElseOnItIsNearer) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const auto draw = [&](std::uint64_t i) { return 2 * uniform(seed, i) - 1; };
    const auto point = [&](std::uint64_t i) { return Point3{draw(i), draw(i + 1), draw(i + 2)}; };
    const std::array<Point3, 3> corners{point(0), point(3), point(6)};
    const Point3 x = point(9);
    const NearestOnTriangle3 found = nearest_on(x, corners);
    for (std::uint64_t i = 0; i < 50; ++i) {
      const double s = uniform(seed + 1000, 2 * i), t = (1 - s) * uniform(seed, 100 + i);
      Point3 p{};
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = s * corners[0][k] + t * corners[1][k] + (1 - s - t) * corners[2][k];
      }
      EXPECT_GE(dot(minus(p, x), minus(p, x)), found.squared * (1 - 1e-12));
    }
  }
}

// A box whose top, at 4, goes up and down.
Steered hilly(std::uint64_t seed, double (*field)(double, double, double), double height = 0.1) {
  Geometry g = five_split_box(10, 10, 4, 0.15, seed);
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    p.z += height * p.z * std::sin(p.x + static_cast<double>(seed)) * std::cos(0.8 * p.y);
  }
  Steered s = testing::steered(std::move(g), field);
  s.mesh.has_deviations = true;
  begin_quadrics(s.fields(), kUnit, &s.mesh);
  return s;
}

// Two vertices of the top become one somewhere between them, a little higher or lower.
struct Fused {
  WorkMesh<double> before, after;
  std::vector<SurfaceTriangle> surface, new_surface;
};

double distance_to_all(const Point3& x, const std::vector<SurfaceTriangle>& surface) {
  double least = std::numeric_limits<double>::infinity();
  for (const SurfaceTriangle& t : surface) least = std::min(least, testing::distance_to(x, t));
  return least;
}

Point3 as_point(const Vec3<double>& p) { return {p.x, p.y, p.z}; }

// Calls f(joining, surface, fused) for some fusions of neighbours on the top.
template <class F>
void for_each_fusion(std::uint64_t seed, F f) {
  Steered s = hilly(seed, testing::smooth, 0.15);
  WorkMesh<double>& mesh = s.mesh;
  testing::count_incidence(&mesh);
  LiveBalls balls;
  balls.reset(mesh.vertex_count(), mesh.tets);
  FuseCavity<double> cavity;
  cavity.begin(&mesh, &balls, 0, 1);
  Sheets<double> sheets;
  sheets.begin(&mesh, &balls, {}, kFeatureAngle);
  SheetFan fan;
  NearSurface<double> surface;
  surface.begin(&mesh, &balls, 1, 1);
  Fused fused{mesh, mesh, testing::surface_of(mesh), {}};
  const auto is_inside_top = [&](VertexId v) {
    const Vec3<double>& p = mesh.positions[v];
    return (mesh.marks[v] & kOnBoundary) != 0 && p.z > 2.5 && p.x > 0 && p.x < 10 && p.y > 0 &&
           p.y < 10;
  };
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto [i, k] = std::array<std::size_t, 2>{t % 3, 1 + t % 3};
    const VertexId v = mesh.tets[t][i], partner = mesh.tets[t][k];
    if (!is_inside_top(v) || !is_inside_top(partner)) continue;
    if (!sheets.find_fan(v, &fan) || !fan.turn_to(partner)) continue;
    if (!sheets.may_contract(v, fan, partner)) continue;
    const Vec3<double>&a = mesh.positions[v], &b = mesh.positions[partner];
    const double share = uniform(seed, t), rise = 0.8 * uniform(seed + 1, t) - 0.4;
    const Vec3<double> at{a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
                          a.z + share * (b.z - a.z) + rise};
    if (cavity.collect(v, partner, false, at)) continue;
    const Joining<double> joining{v, partner, false, at, cavity.affected(), cavity.deleted()};
    fused.after = mesh;
    fused.after.positions[v] = at;
    for (const std::uint32_t entry : cavity.affected()) {
      fused.after.tets[entry >> 2][entry & 3u] = v;
    }
    std::erase_if(fused.after.tets, [&](const Tet& tet) {
      return std::count(tet.begin(), tet.end(), v) + std::count(tet.begin(), tet.end(), partner) >
             1;
    });
    fused.new_surface = testing::surface_of(fused.after);
    surface.set(joining);
    f(joining, &surface, fused);
  }
}

std::array<SurfaceTriangle, 4> faces_of(const WorkMesh<double>& mesh, const Tet& tet) {
  std::array<SurfaceTriangle, 4> faces{};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      faces[k][i] = as_point(mesh.positions[tet[kCornerFirst[k][i + 1]]]);
    }
  }
  return faces;
}

// What settle() says is the nearest of the whole surface.
TEST(NearSurface, KnowsWhatIsNearest) {
  std::size_t settled = 0, not_settled = 0, beyond = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for_each_fusion(seed, [&](const auto& joining, NearSurface<double>* surface, const Fused& f) {
      std::vector<NearSurface<double>::Hit> hits;
      for (std::uint64_t i = 0; i < 20; ++i) {
        const auto draw = [&](std::uint64_t k) { return uniform(seed + k, 100 * joining.v + i); };
        const Vec3<double> x{joining.position.x + 2 * draw(1) - 1,
                             joining.position.y + 2 * draw(2) - 1,
                             joining.position.z + 0.5 * draw(3) - 0.1};
        if (testing::is_held(f.after, x)) continue;
        const double patch = std::sqrt(surface->find(x, &hits));
        if (!surface->settle(x, &hits)) {
          ++not_settled;
          continue;
        }
        ++settled;
        const double found = std::sqrt(hits.front().nearest.squared);
        beyond += found < patch * (1 - 1e-6) ? 1 : 0;
        EXPECT_NEAR(found, distance_to_all(as_point(x), f.new_surface), 1e-9);
      }
    });
  }
  EXPECT_GT(settled, 300u);
  EXPECT_GT(not_settled, 100u);
  EXPECT_GT(beyond, 30u);
}

// A point outside that a neighbour has is spared only if what is nearest to it stays so.
TEST(NearSurface, SparesWhatStaysNearest) {
  std::size_t spared = 0, not_spared = 0, disturbed = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for_each_fusion(seed, [&](const auto& joining, NearSurface<double>* surface, const Fused& f) {
      ASSERT_TRUE(surface->know_neighbours());
      for (const TetId t : surface->neighbours()) {
        const auto draw = [&](std::uint64_t k) { return uniform(seed + k, 64 * t + joining.v); };
        const Vec3<double>&a = f.before.positions[f.before.tets[t][0]],
              &b = f.before.positions[f.before.tets[t][1]];
        const Vec3<double> x{(a.x + b.x) / 2 + draw(1) - 0.5, (a.y + b.y) / 2 + draw(2) - 0.5,
                             std::max(a.z, b.z) + 0.3 * draw(3)};
        if (testing::is_held(f.before, x)) continue;
        const double before = distance_to_all(as_point(x), f.surface);
        const auto faces = faces_of(f.before, f.before.tets[t]);
        const bool is_home = std::any_of(faces.begin(), faces.end(), [&](const auto& face) {
          return testing::distance_to(as_point(x), face) < before * (1 + 1e-9);
        });
        if (!is_home) continue;
        const double after = distance_to_all(as_point(x), f.new_surface);
        disturbed += after < before * (1 - 1e-6) ? 1 : 0;
        if (!surface->spares(t, x)) {
          ++not_spared;
          continue;
        }
        ++spared;
        EXPECT_GE(after, before * (1 - 1e-6));
      }
    });
  }
  EXPECT_GT(spared, 100u);
  EXPECT_GT(not_spared, 10u);
  EXPECT_GT(disturbed, 5u);
}

double steep(double x, double y, double z) { return std::tanh(3 * (x + 0.3 * y - 6)) + z / 4; }

// Whoever takes the nearest point of the whole surface finds each field within its bound, after
// every round, even if the surface moves by half an edge and the field knows no neighbours.
TEST(NearSurface, BoundsHoldOutside) {
  std::size_t outside = 0;
  double furthest = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const auto field : {testing::smooth, steep, testing::rough}) {
      const bool is_rough = field == testing::rough;
      for (const double max_error : {is_rough ? 0.5 : 3e-3, is_rough ? 0.3 : 2e-2}) {
        Steered s = hilly(seed, field, is_rough ? 0.15 : 0.1);
        const WorkMesh<double> before = s.mesh;
        FuseLimits limits = testing::limits_of();
        limits.max_deviation = is_rough ? 0.1 : 0.02;
        limits.min_quality = 0.05;
        limits.sheet_weight = is_rough ? 1 : 1000;
        limits.max_error = max_error;
        FuseRound<double> round;
        for (const double threshold : {1e-4, 1e-2, 1.0, 100.0}) {
          limits.threshold = threshold;
          round.run(limits, s.fields(), &s.mesh);
          const auto found = testing::outside_deviation(before, s.mesh, s.field);
          EXPECT_LE(found.worst, max_error);
          outside += found.points;
          furthest = std::max(furthest, found.furthest);
        }
        EXPECT_EQ(testing::brute_check(testing::to_geometry(s.mesh)).positive, s.mesh.tets.size());
      }
    }
  }
  EXPECT_GT(outside, 500u);
  EXPECT_GT(furthest, 0.3);
}

// Nothing is said of what lies beyond a vertex that other chunks have, too: next to it no part of
// the boundary moves that is not flat.
TEST(NearSurface, StaysWhereItCannotSee) {
  for (const bool seen : {true, false}) {
    Steered s = hilly(1, testing::smooth);
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      const Vec3<double>& p = s.mesh.positions[v];
      if (!seen && p.z > 3 && std::lround(p.x + p.y) % 3 == 0) s.mesh.marks[v] |= kOnInterface;
    }
    FuseLimits limits = testing::limits_of();
    limits.max_deviation = 0.02;
    limits.max_error = 0.5;
    run(limits, &s);
    float most = 0;
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      if (s.mesh.positions[v].z > 3) most = std::max(most, s.mesh.deviations[v]);
    }
    EXPECT_EQ(most > kOnSurface, seen) << most;
  }
}

}  // namespace
}  // namespace tetfusion
