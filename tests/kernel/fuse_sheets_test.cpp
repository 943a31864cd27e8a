// Fusions that move the boundary, and surfaces between regions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "kernel/fuse/fuse_round.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "support/fuse_meshes.h"
#include "support/surfaces.h"

namespace tetfusion {
namespace {

using testing::brute_check;
using testing::distance_between;
using testing::euler_number;
using testing::expect_whole;
using testing::five_split_box;
using testing::five_split_cube;
using testing::kUnit;
using testing::limits_of;
using testing::rejected;
using testing::smooth;
using testing::Steered;
using testing::surface_between;
using testing::surface_of;
using testing::SurfaceTriangle;

constexpr double kPlanar = 1e-6;

// A mesh whose sheets may move, seen from outside.
Steered moving(Geometry g, std::vector<std::int32_t> regions = {}, double unit = kUnit) {
  Steered s = testing::steered(std::move(g), smooth, unit);
  if (!regions.empty()) {
    s.mesh.cell_columns.push_back(
        testing::make_column(1, Vector<std::int32_t>(regions.begin(), regions.end())));
  }
  s.mesh.has_deviations = true;
  begin_quadrics(s.fields(), unit, &s.mesh);
  return s;
}

// Rounds with rising thresholds, each of which knows what the one before has left.
FuseStatistics run_rounds(double max_deviation, Steered* s, double unit = kUnit) {
  FuseLimits limits = limits_of();
  limits.unit = unit;
  limits.max_deviation = max_deviation;
  limits.sheet_weight = 1000;
  if (!s->mesh.cell_columns.empty()) limits.regions = {0};
  FacingGrid facing, next;
  FacingBox box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
  for (const Vec3<double>& p : s->mesh.positions) box.add({p.x, p.y, p.z});
  FuseRound<double> round;
  FuseStatistics all;
  std::uint64_t fused = 0;
  for (const double threshold : {0.0, 1e-4, 1e-3, 1e-2, 1.0}) {
    limits.threshold = threshold;
    limits.facing = facing.empty() ? nullptr : &facing;
    next.reset(box);
    limits.facing_after = &next;
    all = threshold == 0 ? round.look(limits, s->fields(), &s->mesh)
                         : round.run(limits, s->fields(), &s->mesh);
    fused += all.pass.fused;
    std::swap(facing, next);
  }
  all.pass.fused = fused;
  return all;
}

void expect_valid(const WorkMesh<double>& mesh, const WorkMesh<double>& before) {
  const auto report = brute_check(testing::to_geometry(mesh));
  const auto expected = brute_check(testing::to_geometry(before));
  EXPECT_EQ(report.positive, mesh.tets.size());
  EXPECT_TRUE(report.conforming());
  EXPECT_EQ(report.nonmanifold_edges, expected.nonmanifold_edges);
  EXPECT_EQ(report.nonmanifold_vertices, expected.nonmanifold_vertices);
  EXPECT_EQ(report.components, expected.components);
  EXPECT_EQ(euler_number(report.boundary), euler_number(expected.boundary));
  expect_whole(mesh);
}

// Moves the inside of the box up and down, by at most 0.4 at the top, which is at `height`.
Geometry wavy(Geometry g, double height, double phase = 0) {
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    p.z += 0.4 * p.z / height * std::sin(p.x + phase) * std::cos(0.8 * p.y);
  }
  return g;
}

TEST(FuseSheets, ABoxStaysABox) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Steered s = moving(five_split_cube(8, 0.2, seed));
    const WorkMesh<double> before = s.mesh;
    const FuseStatistics statistics = run_rounds(kPlanar, &s);
    expect_valid(s.mesh, before);
    EXPECT_LT(s.mesh.tets.size(), before.tets.size() / 10);
    EXPECT_LT(surface_of(s.mesh).size(), surface_of(before).size() / 4);
    EXPECT_NEAR(testing::volume(s.mesh), 512, 1e-10);
    EXPECT_LT(statistics.deviation, 1e-12);
    std::size_t corners = 0;
    for (std::size_t v = 0; v < s.mesh.vertex_count(); ++v) {
      const Vec3<double>& p = s.mesh.positions[v];
      const auto on = [](double x) { return x == 0 || x == 8 ? 1 : 0; };
      const int sides = on(p.x) + on(p.y) + on(p.z);
      EXPECT_EQ(sides > 0, (s.mesh.marks[v] & kOnBoundary) != 0);
      corners += sides == 3 ? 1 : 0;
    }
    EXPECT_EQ(corners, 8u);
  }
}

TEST(FuseSheets, SheetsStayUnlessTheyMay) {
  Steered s = moving(five_split_cube(6, 0.2, 3));
  const WorkMesh<double> before = s.mesh;
  FuseRound<double>().run(limits_of(), s.fields(), &s.mesh);
  testing::expect_same_domain(s.mesh, before);
}

// Nor in a round in which they rest, those between regions included.
TEST(FuseSheets, SheetsMayRestForARound) {
  Geometry g = five_split_cube(8, 0.2, 3);
  std::vector<std::int32_t> regions;
  for (std::size_t t = 0; t < g.tets.size(); ++t) regions.push_back(t < g.tets.size() / 2 ? 1 : 2);
  Steered s = moving(g, regions);
  const WorkMesh<double> before = s.mesh;
  FuseLimits limits = limits_of();
  limits.max_deviation = 0.01;
  limits.regions = {0};
  limits.sheets_rest = true;
  const FuseStatistics statistics = FuseRound<double>().run(limits, s.fields(), &s.mesh);
  EXPECT_GT(statistics.pass.fused, 50u);
  EXPECT_EQ(statistics.deviation, 0);
  testing::expect_same_domain(s.mesh, before);
  EXPECT_EQ(surface_between(s.mesh).size(), surface_between(before).size());
}

// The bound is one both ways, and the surface uses some of it.
TEST(FuseSheets, TheDeviationIsABound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const double share : {0.002, 0.01}) {
      Steered s = moving(wavy(five_split_box(9, 9, 4, 0.15, seed), 4));
      const WorkMesh<double> before = s.mesh;
      const FuseStatistics statistics = run_rounds(share, &s);
      expect_valid(s.mesh, before);
      EXPECT_LT(surface_of(s.mesh).size(), surface_of(before).size() * 3 / 4);
      EXPECT_LE(statistics.deviation, share);
      const double moved = distance_between(surface_of(s.mesh), surface_of(before)) * kUnit;
      EXPECT_LE(moved, statistics.deviation);
      EXPECT_GT(moved, statistics.deviation / 20);
    }
  }
}

TEST(FuseSheets, APlateIsNotPinched) {
  for (const double deviation : {kPlanar, 0.02, 0.5}) {
    Steered s = moving(testing::plate(8));
    const WorkMesh<double> before = s.mesh;
    run_rounds(deviation, &s);
    expect_valid(s.mesh, before);
    EXPECT_LT(s.mesh.tets.size(), before.tets.size() / 2);
    EXPECT_NEAR(testing::volume(s.mesh), 64, 1e-11);
  }
}

std::vector<std::int32_t> halves(const Geometry& g, double at) {
  std::vector<std::int32_t> regions;
  for (const Tet& t : g.tets) {
    double x = 0;
    for (const VertexId v : t) x += testing::point(g, v).x / 4;
    regions.push_back(x < at ? -3 : 5);
  }
  return regions;
}

std::map<std::int32_t, double> volumes(const WorkMesh<double>& mesh) {
  std::map<std::int32_t, double> out;
  const auto regions = testing::values_of<std::int32_t>(mesh.cell_columns[0]);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    out[regions[t]] += determinant(mesh.positions, mesh.tets[t]).value / 6;
  }
  return out;
}

TEST(FuseSheets, RegionsKeepTheirVolumes) {
  Geometry g = five_split_cube(8);
  Steered s = moving(g, halves(g, 4));
  const WorkMesh<double> before = s.mesh;
  run_rounds(kPlanar, &s);
  expect_valid(s.mesh, before);
  EXPECT_LT(s.mesh.tets.size(), before.tets.size() / 4);
  EXPECT_NEAR(volumes(s.mesh)[-3], 256, 1e-10);
  EXPECT_NEAR(volumes(s.mesh)[5], 256, 1e-10);
  std::size_t inside = 0, rim = 0;
  for (const Vec3<double>& p : s.mesh.positions) {
    if (p.x != 4) continue;
    const bool outer = p.y == 0 || p.y == 8 || p.z == 0 || p.z == 8;
    ++(outer ? rim : inside);
  }
  EXPECT_EQ(rim, 32u);     // where three sheets meet
  EXPECT_LT(inside, 30u);  // of 49
  EXPECT_GT(inside, 0u);
}

// A surface between regions moves no further than it may; the outer one does not move here.
TEST(FuseSheets, ASurfaceBetweenRegionsMovesWithinItsBound) {
  Geometry g = five_split_cube(8, 0.15, 2);
  const std::vector<std::int32_t> regions = halves(g, 4);
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    p.x += 0.02 * p.x * (8 - p.x) * std::sin(0.7 * p.y) * std::cos(0.5 * p.z);
  }
  Steered s = moving(g, regions);
  const WorkMesh<double> before = s.mesh;
  const FuseStatistics statistics = run_rounds(0.01, &s);
  expect_valid(s.mesh, before);
  const auto old_sheet = surface_between(before), new_sheet = surface_between(s.mesh);
  EXPECT_LT(new_sheet.size(), old_sheet.size() * 3 / 4);
  EXPECT_LE(distance_between(old_sheet, new_sheet) * kUnit, statistics.deviation);
  EXPECT_LE(statistics.deviation, 0.01F);
  EXPECT_LT(distance_between(surface_of(before), surface_of(s.mesh)) * kUnit, 1e-12);
}

// Two slabs whose surfaces wave side by side, so near that they could meet.
TEST(FuseSheets, PartsDoNotMeetAcrossAGap) {
  Geometry g = wavy(five_split_box(12, 12, 2, 0.15, 1), 2);
  Geometry above = five_split_box(12, 12, 2, 0.15, 2);
  constexpr double kGap = 0.05;
  auto& points = std::get<Vector<Vec3<double>>>(g.points);
  const auto below = static_cast<VertexId>(points.size());
  for (Vec3<double> p : std::get<Vector<Vec3<double>>>(above.points)) {
    p.z += 2 + kGap + 0.4 * (1 - p.z / 2) * std::sin(p.x) * std::cos(0.8 * p.y);
    points.push_back(p);
  }
  for (Tet t : above.tets) {
    for (VertexId& v : t) v += below;
    g.tets.push_back(t);
  }
  Steered s = moving(g);
  const WorkMesh<double> before = s.mesh;
  run_rounds(0.1, &s);
  expect_valid(s.mesh, before);
  EXPECT_LT(surface_of(s.mesh).size(), surface_of(before).size() / 2);
  std::vector<SurfaceTriangle> top, bottom;
  for (const SurfaceTriangle& t : surface_of(s.mesh)) {
    const Point3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    const double z = (t[0][2] + t[1][2] + t[2][2]) / 3;
    if (z < 1 || z > 3.4) continue;
    if (n[2] > 0.3 * std::sqrt(dot(n, n))) top.push_back(t);
    if (n[2] < -0.3 * std::sqrt(dot(n, n))) bottom.push_back(t);
  }
  int compared = 0;
  for (int i = 1; i < 60; ++i) {
    for (int k = 1; k < 60; ++k) {
      const double x = 0.2 * i + 0.003, y = 0.2 * k + 0.001;
      const auto low = testing::height_of(top, x, y), high = testing::height_of(bottom, x, y);
      if (!low || !high) continue;
      ++compared;
      EXPECT_LT(*low, *high) << x << " " << y;
    }
  }
  EXPECT_GT(compared, 3000);
  EXPECT_EQ(testing::count_crossings(surface_of(s.mesh)), 0u);
}

// Both sides of a thin wall that waves may rise, as may the lines along its rim: the other side
// lies behind.
TEST(FuseSheets, AThinWallIsNotInItsOwnWay) {
  constexpr double kThickness = 0.4;
  Geometry g = five_split_box(24, 16, 1, 0, 1);
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    p.z = kThickness * p.z + 0.4 * std::sin(0.6 * p.x) * std::cos(0.5 * p.y);
  }
  Steered s = moving(g);
  testing::steer_by(testing::linear, &s.mesh);
  begin_quadrics(s.fields(), kUnit, &s.mesh);
  const WorkMesh<double> before = s.mesh;
  ASSERT_TRUE(testing::all_positive(before));
  run_rounds(0.02, &s);
  expect_valid(s.mesh, before);
  EXPECT_LT(surface_of(s.mesh).size(), surface_of(before).size() / 2);
  const auto on_rim = [](const WorkMesh<double>& mesh) {
    return std::count_if(mesh.positions.begin(), mesh.positions.end(),
                         [](const auto& p) { return std::abs(p.y) < 1e-3; });
  };
  EXPECT_EQ(on_rim(before), 50);
  EXPECT_LT(on_rim(s.mesh), 35);
  EXPECT_EQ(testing::count_crossings(surface_of(s.mesh)), 0u);
}

// A thin wall, bent so little that the ridge is no line: its vertices go along the ridge, which is
// no rise but for what single precision makes of it, though the other side looks against them
// nearby.
TEST(FuseSheets, ARidgeOfAThinWallNeedsFewVertices) {
  constexpr double kThickness = 0.35, kSlope = 0.3, kMiddle = 8, kTurn = 0.5;
  Geometry g = five_split_box(16, 12, 1, 0, 1);
  for (Vec3<double>& p : std::get<Vector<Vec3<double>>>(g.points)) {
    const double x = p.x - kMiddle;
    const std::array<double, 3> turned{std::cos(kTurn) * x - std::sin(kTurn) * p.y,
                                       std::sin(kTurn) * x + std::cos(kTurn) * p.y,
                                       kThickness * p.z + kSlope * std::abs(x)};
    p = {static_cast<float>(turned[0]), static_cast<float>(turned[1]),
         static_cast<float>(turned[2])};
  }
  Steered s = moving(g);
  testing::steer_by(testing::linear, &s.mesh);
  begin_quadrics(s.fields(), kUnit, &s.mesh);
  const WorkMesh<double> before = s.mesh;
  run_rounds(0.01, &s);
  expect_valid(s.mesh, before);
  const auto on_ridge = [&](const WorkMesh<double>& mesh) {
    return std::count_if(mesh.positions.begin(), mesh.positions.end(), [](const auto& p) {
      const double x = std::cos(kTurn) * p.x + std::sin(kTurn) * p.y;
      return std::abs(x) < 0.01 && std::abs(p.z - kThickness) < 0.01;
    });
  };
  EXPECT_EQ(on_ridge(before), 13);
  EXPECT_LE(on_ridge(s.mesh), 6);
  EXPECT_LT(distance_between(surface_of(s.mesh), surface_of(before)) * kUnit, 1e-4);
}

// A crack across the middle of a box of six: two sides, with points of their own inside a square.
Geometry cracked_box() {
  Geometry g = five_split_cube(6, 0.15, 4);
  auto& points = std::get<Vector<Vec3<double>>>(g.points);
  std::map<VertexId, VertexId> twin;
  for (VertexId v = 0, n = static_cast<VertexId>(points.size()); v < n; ++v) {
    const auto [i, j, k] = std::array{v % 7, v / 7 % 7, v / 49};
    if (k != 3 || i < 1 || i > 5 || j < 1 || j > 5) continue;
    points[v] = {static_cast<double>(i), static_cast<double>(j), 3};
    if (i == 1 || i == 5 || j == 1 || j == 5) continue;  // the tip
    twin[v] = static_cast<VertexId>(points.size());
    points.push_back(points[v]);
  }
  for (std::size_t t = 0; t < g.tets.size(); ++t) {
    if (t / 5 / 36 < 3) continue;  // a cube below
    for (VertexId& v : g.tets[t]) {
      if (twin.contains(v)) v = twin[v];
    }
  }
  return g;
}

// Of the triangles in the crack's plane, those that look down and those that look up.
std::array<double, 2> areas_of_crack(const WorkMesh<double>& mesh) {
  std::array<double, 2> area{};
  for (const SurfaceTriangle& t : surface_of(mesh)) {
    const Point3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    if (t[0][2] != 3 || t[1][2] != 3 || t[2][2] != 3) continue;
    area[n[2] > 0 ? 1 : 0] += std::abs(n[2]) / 2;
  }
  return area;
}

TEST(FuseSheets, ACrackKeepsItsTwoSides) {
  for (const double deviation : {kPlanar, 0.01}) {
    Steered s = moving(cracked_box());
    const WorkMesh<double> before = s.mesh;
    ASSERT_TRUE(testing::all_positive(before));
    run_rounds(deviation, &s);
    expect_valid(s.mesh, before);
    EXPECT_LT(surface_of(s.mesh).size(), surface_of(before).size() / 2);
    const auto now = areas_of_crack(s.mesh), was = areas_of_crack(before);
    for (const std::size_t side : {0, 1}) {
      EXPECT_EQ(was[side], 14);
      EXPECT_NEAR(now[side], 14, 1e-12);
    }
  }
}

// Locked ones and those on an interface stay, and so does what is known of the latter.
TEST(FuseSheets, MarkedVerticesStay) {
  Steered s = moving(wavy(five_split_box(8, 8, 4, 0.15, 3), 4));
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const double draw = testing::uniform(5, v);
    if (draw < 0.1) s.mesh.marks[v] |= kLocked;
    if (draw > 0.9) s.mesh.marks[v] |= kOnInterface;
  }
  const WorkMesh<double> before = s.mesh;
  EXPECT_GT(run_rounds(0.01, &s).pass.fused, 100u);
  expect_valid(s.mesh, before);
  std::map<VertexId, VertexId> now;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) now[s.mesh.point_ids[v]] = v;
  for (VertexId v = 0; v < before.vertex_count(); ++v) {
    if ((before.marks[v] & (kLocked | kOnInterface)) == 0) continue;
    ASSERT_TRUE(now.contains(v));
    EXPECT_EQ(testing::at(s.mesh, now[v]), testing::at(before, v));
    if ((before.marks[v] & kOnInterface) != 0) {
      EXPECT_EQ(s.mesh.deviations[now[v]], 0);
    }
  }
}

TEST(FuseSheets, TheScaleOfAMeshDoesNotMatter) {
  const Geometry g = wavy(five_split_box(8, 8, 4, 0.15, 4), 4);
  Steered s = moving(g);
  run_rounds(0.01, &s);
  for (const double scale : {0x1p-20, 0x1p20}) {
    Steered other = moving(g);
    for (Vec3<double>& p : other.mesh.positions) p = {p.x * scale, p.y * scale, p.z * scale};
    begin_quadrics(other.fields(), kUnit / scale, &other.mesh);
    run_rounds(0.01, &other, kUnit / scale);
    EXPECT_EQ(other.mesh.tets, s.mesh.tets);
    EXPECT_EQ(other.mesh.deviations, s.mesh.deviations);
  }
}

// A field that is linear stays so, but where the surface has risen: there it keeps to the values
// that there were.
TEST(FuseSheets, LinearFieldsStayLinear) {
  Geometry g = five_split_cube(8, 0.2, 2);
  Steered s = testing::steered(std::move(g), testing::linear);
  s.mesh.has_deviations = true;
  begin_quadrics(s.fields(), kUnit, &s.mesh);
  Vector<double> carried;
  for (const auto& p : s.mesh.positions) carried.push_back(testing::linear(p.x, p.y, p.z));
  s.mesh.point_columns.push_back(testing::make_column(1, carried));
  EXPECT_GT(run_rounds(kPlanar, &s).pass.fused, 400u);
  const auto values = testing::values_of<double>(s.mesh.point_columns[0]);
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const Vec3<double>& p = s.mesh.positions[v];
    EXPECT_NEAR(s.mesh.steering[v], testing::linear(p.x, p.y, p.z), 1e-5 * s.field.range);
    EXPECT_NEAR(values[v], testing::linear(p.x, p.y, p.z), 1e-11);
  }
}

}  // namespace
}  // namespace tetfusion
