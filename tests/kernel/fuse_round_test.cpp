#include "kernel/fuse/fuse_round.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "support/fuse_meshes.h"
#include "support/point_deviation.h"

namespace tetfusion {
namespace {

using testing::at;
using testing::expect_same_domain;
using testing::expect_whole;
using testing::five_split_cube;
using testing::kuhn_box;
using testing::kUnit;
using testing::limits_of;
using testing::linear;
using testing::make_column;
using testing::range_of;
using testing::rejected;
using testing::rough;
using testing::run;
using testing::smooth;
using testing::Steered;
using testing::steered;
using testing::to_work_mesh;
using testing::uniform;
using testing::values_of;

std::map<VertexId, VertexId> by_id(const WorkMesh<double>& mesh) {
  std::map<VertexId, VertexId> out;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) out[mesh.point_ids[v]] = v;
  return out;
}

// Whether everything but what costs are known is the same.
void expect_same(const WorkMesh<double>& a, const WorkMesh<double>& b, double scale = 1) {
  ASSERT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.point_ids, b.point_ids);
  EXPECT_EQ(a.incidence, b.incidence);
  EXPECT_EQ(a.steering, b.steering);
  EXPECT_EQ(a.quadrics, b.quadrics);
  for (std::size_t v = 0; v < a.vertex_count(); ++v) {
    EXPECT_EQ(a.positions[v].x * scale, b.positions[v].x);
    EXPECT_EQ(a.positions[v].y * scale, b.positions[v].y);
    EXPECT_EQ(a.positions[v].z * scale, b.positions[v].z);
  }
  for (std::size_t c = 0; c < a.point_columns.size(); ++c) {
    EXPECT_EQ(a.point_columns[c].rows, b.point_columns[c].rows);
  }
}

// Of the field that steers, in the tetrahedron that has the point.
double value_at(const WorkMesh<double>& mesh, const Vec3<double>& x) {
  double deepest = -std::numeric_limits<double>::infinity(), value = 0;
  for (const Tet& tet : mesh.tets) {
    const double whole = determinant(mesh.positions, tet).value;
    double least = 1, sum = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto& order = kCornerFirst[c];
      const auto corner = [&](std::size_t i) { return mesh.positions[tet[order[i]]]; };
      const double share = determinant(x, corner(1), corner(2), corner(3)).value / whole;
      least = std::min(least, share);
      sum += share * mesh.steering[tet[order[0]]];
    }
    if (!(least > deepest)) continue;
    deepest = least;
    value = sum;
  }
  return value;
}

// When the centre of an icosahedron goes to one of the twelve, the five tetrahedra there go.
TEST(FuseRound, TheCentreOfABallGoesToTheBoundary) {
  Steered s = steered(testing::icosahedron_ball(), linear);
  const WorkMesh<double> before = s.mesh;
  const FuseStatistics statistics = run(limits_of(), &s);
  EXPECT_EQ(statistics.pass.fused, 1u);
  EXPECT_EQ(statistics.pass.tets_before, 20u);
  EXPECT_EQ(statistics.pass.tets_after, 15u);
  EXPECT_EQ(s.mesh.tets.size(), 15u);
  EXPECT_EQ(s.mesh.vertex_count(), 12u);
  EXPECT_EQ(rejected(statistics, Reject::kBoundary), 12u);
  expect_same_domain(s.mesh, before);
  expect_whole(s.mesh);
}

// Each vertex of an icosahedron has one more cell, that overlaps the others: with an edge across
// the ball, or with a vertex there. Were it joined with the centre, a face or an edge would be
// there twice.
TEST(FuseRound, WhatOverlapsIsNotJoined) {
  const Geometry ball = testing::icosahedron_ball();
  const auto has = [](const Tet& t, VertexId v) { return std::ranges::count(t, v) == 1; };
  for (const bool by_edge : {true, false}) {
    Geometry mesh = ball;
    auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
    for (VertexId p = 1; p <= 12; ++p) {
      const Tet* across = nullptr;
      for (const Tet& t : ball.tets) {
        if (std::ranges::none_of(t, [&](VertexId v) {
              return v != 0 && std::ranges::any_of(
                                   ball.tets, [&](const Tet& o) { return has(o, p) && has(o, v); });
            })) {
          across = &t;
        }
      }
      ASSERT_NE(across, nullptr);
      const auto first = static_cast<VertexId>(points.size());
      points.insert(points.end(), 2, {3.0 + p, 1.0 / p, 0.5 * p});
      points.back().z += 1;
      Tet more{p, (*across)[1], by_edge ? (*across)[2] : first + 1, first};
      mesh.tets.push_back(more);
      if (!(determinant(points, more).value > 0))
        std::swap(mesh.tets.back()[2], mesh.tets.back()[3]);
    }
    Steered s = steered(mesh, linear);
    const Vector<Tet> before = s.mesh.tets;
    EXPECT_EQ(run(limits_of(), &s).pass.fused, 0u);
    EXPECT_EQ(s.mesh.tets, before);
  }
}

TEST(FuseRound, LeavesAMeshWithoutInteriorVertices) {
  for (const Geometry& g : {testing::single_tet(), testing::two_tets_sharing_face(),
                            testing::plate(4), five_split_cube(1)}) {
    Steered s = steered(g, linear);
    const WorkMesh<double> before = s.mesh;
    const FuseStatistics statistics = run(limits_of(), &s);
    EXPECT_EQ(statistics.pass.fused, 0u);
    EXPECT_EQ(rejected(statistics, Reject::kBoundary), before.vertex_count());
    EXPECT_EQ(s.mesh.tets, before.tets);
  }
}

// A field that is linear but for bends along two planes can do without most vertices.
TEST(FuseRound, LeavesBendsWhereTheyAre) {
  Steered s = steered(five_split_cube(10, 0, 1), [](double x, double, double z) {
    return std::abs(x - 5) + std::max(z - 4, 0.0);
  });
  const WorkMesh<double> before = s.mesh;
  FuseLimits limits = limits_of(1e-7);
  limits.quota = before.tets.size() * 45 / 100;
  run(limits, &s);
  EXPECT_LE(s.mesh.tets.size(), before.tets.size() * 56 / 100);
  EXPECT_LT(testing::worst_deviation(before, s.mesh, s.field), 1e-4);
  expect_whole(s.mesh);
}

TEST(FuseRound, KeepsTheMeshValid) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const auto f : {smooth, rough, linear}) {
      Steered s =
          steered(seed % 2 == 0 ? kuhn_box(9, 8, 7, 0.15, seed) : five_split_cube(9, 0.2, seed), f);
      const WorkMesh<double> before = s.mesh;
      FuseRound<double> round;
      for (const double threshold : {1e-4, 1e-2, 1.0}) {
        const FuseStatistics statistics = round.run(limits_of(threshold), s.fields(), &s.mesh);
        EXPECT_EQ(statistics.pass.tets_after, s.mesh.tets.size());
        const auto& reasons = statistics.pass.rejected;
        EXPECT_EQ(std::accumulate(reasons.begin(), reasons.end(), 0ULL), s.mesh.vertex_count());
        expect_same_domain(s.mesh, before);
        expect_whole(s.mesh);
      }
      EXPECT_LT(s.mesh.tets.size(), before.tets.size() / 2);
    }
  }
}

TEST(FuseRound, VerticesAtNewPlacesAreMarked) {
  Steered s = steered(five_split_cube(9, 0.2, 3), smooth);
  const WorkMesh<double> before = s.mesh;
  run(limits_of(), &s);
  const auto first = by_id(before);
  std::size_t moved = 0, stayed = 0;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const Vec3<double>& p = s.mesh.positions[v];
    const Vec3<double>& q = before.positions[first.at(s.mesh.point_ids[v])];
    const bool is_there = p.x == q.x && p.y == q.y && p.z == q.z;
    EXPECT_EQ((s.mesh.marks[v] & kMoved) == 0, is_there);
    ++(is_there ? stayed : moved);
  }
  EXPECT_GT(moved, 5u);
  EXPECT_GT(stayed, 10u);
}

TEST(FuseRound, KeepsAMeshOfFloatsValid) {
  WorkMesh<float> mesh = testing::to_float_work_mesh(five_split_cube(10, 0.2, 3));
  testing::steer_by(smooth, &mesh);
  const SteeringField field = range_of(mesh);
  begin_quadrics({&field, 1}, kUnit, &mesh);
  const WorkMesh<float> before = mesh;
  FuseRound<float>().run(limits_of(), {&field, 1}, &mesh);
  EXPECT_LT(mesh.tets.size(), before.tets.size() / 2);
  expect_same_domain(mesh, before);
  expect_whole(mesh);
}

TEST(FuseRound, FusesWithoutAnyField) {
  WorkMesh<double> mesh = to_work_mesh(five_split_cube(8, 0.2, 3));
  begin_quadrics({}, kUnit, &mesh);
  const WorkMesh<double> before = mesh;
  const FuseStatistics s = FuseRound<double>().run(limits_of(), {}, &mesh);
  EXPECT_GT(s.pass.fused, 100u);
  expect_same_domain(mesh, before);
  expect_whole(mesh);
}

// Locked ones stay, though others may come to them; those on an interface know nobody, and are
// counted where they are last.
TEST(FuseRound, MarkedVerticesStay) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Steered s = steered(five_split_cube(9, 0.2, seed), smooth);
    std::uint64_t last = 0;
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      const double draw = uniform(seed, v);
      if (draw < 0.1) s.mesh.marks[v] |= kLocked;
      if (draw <= 0.9) continue;
      s.mesh.marks[v] |= kOnInterface;
      if (v % 2 == 0) s.mesh.marks[v] |= kLast;
      // On the boundary it would stay anyway, and that is what is said then.
      last += v % 2 == 0 && (s.mesh.marks[v] & kOnBoundary) == 0 ? 1 : 0;
    }
    const WorkMesh<double> before = s.mesh;
    const FuseStatistics statistics = run(limits_of(), &s);
    EXPECT_GT(statistics.pass.fused, 50u);
    EXPECT_GT(rejected(statistics, Reject::kLocked), 20u);
    EXPECT_GT(last, 10u);
    EXPECT_EQ(rejected(statistics, Reject::kInterface), last);
    expect_same_domain(s.mesh, before);
    const auto ids = by_id(s.mesh);
    const std::uint32_t row = before.quadric_width;
    bool took_in = false;
    for (VertexId v = 0; v < before.vertex_count(); ++v) {
      if ((before.marks[v] & (kOnBoundary | kLocked | kOnInterface)) == 0) continue;
      ASSERT_TRUE(ids.contains(v));
      const VertexId w = ids.at(v);
      EXPECT_EQ(s.mesh.marks[w], before.marks[v]);
      EXPECT_EQ(at(s.mesh, w), at(before, v));
      EXPECT_EQ(s.mesh.steering[w], before.steering[v]);
      const bool is_same =
          std::equal(before.quadrics.begin() + v * row, before.quadrics.begin() + (v + 1) * row - 1,
                     s.mesh.quadrics.begin() + w * row);
      took_in = took_in || ((before.marks[v] & kLocked) != 0 && !is_same);
      if ((before.marks[v] & kOnInterface) != 0) {
        EXPECT_TRUE(is_same);
      }
    }
    EXPECT_TRUE(took_in);
  }
}

// The fused vertex's values come from the quadrics, in single precision; those of a carried column
// from the old cavity.
TEST(FuseRound, LinearFieldsStayLinear) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Steered s = steered(five_split_cube(10, 0.2, seed), linear);
    Vector<double> carried, steering(s.mesh.steering);
    for (const auto& p : s.mesh.positions) {
      carried.insert(carried.end(), {linear(p.x, p.y, p.z), -p.y});
    }
    s.mesh.point_columns.push_back(make_column(2, carried));
    for (double& x : steering) x = std::ldexp(x, -3);
    s.mesh.point_columns.push_back(make_column(1, steering));
    s.field.column = 1;
    s.field.exponent = 3;
    const FuseStatistics statistics = run(limits_of(), &s);
    EXPECT_GT(statistics.pass.fused, 200u);
    const auto values = values_of<double>(s.mesh.point_columns[0]);
    const auto steers = values_of<double>(s.mesh.point_columns[1]);
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      const Vec3<double>& p = s.mesh.positions[v];
      const double expected = linear(p.x, p.y, p.z);
      EXPECT_NEAR(s.mesh.steering[v], expected, 1e-5 * s.field.range);
      EXPECT_EQ(steers[v], std::ldexp(s.mesh.steering[v], -3));
      EXPECT_NEAR(values[2 * v], expected, 1e-12);
      EXPECT_NEAR(values[2 * v + 1], -p.y, 1e-12);
    }
  }
}

// At a bend the quadrics of vertices on either side are content with tetrahedra that cut across.
TEST(FuseRound, WhatGoesIsNotCutOff) {
  const auto bend = [](double x, double y, double z) {
    return std::max(0.0, x + 0.3 * y + 0.1 * z - 8);
  };
  double sum = 0, largest = 0;
  std::size_t points = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Steered s = steered(five_split_cube(12, 0.3, seed), bend);
    const WorkMesh<double> before = s.mesh;
    run(limits_of(1e-4), &s);
    for (VertexId v = 0; v < before.vertex_count(); ++v) {
      const double value = value_at(s.mesh, before.positions[v]);
      const double error = std::abs(value - before.steering[v]) / s.field.range;
      largest = std::max(largest, error);
      sum += error * error;
      ++points;
    }
  }
  EXPECT_LT(largest, 0.02);                                        // 0.032 without that
  EXPECT_LT(std::sqrt(sum / static_cast<double>(points)), 0.001);  // 0.0018
}

TEST(FuseRound, IntegersTakeAValueThatWasThere) {
  Steered s = steered(five_split_cube(9, 0.2, 5), smooth);
  const WorkMesh<double> before = s.mesh;
  Vector<std::int64_t> ids;
  Vector<std::uint8_t> pairs;
  for (VertexId v = 0; v < before.vertex_count(); ++v) {
    ids.push_back(1'000'000 + 7 * std::int64_t{v});
    pairs.insert(pairs.end(), {static_cast<std::uint8_t>(v % 251), std::uint8_t{9}});
  }
  s.mesh.point_columns = {make_column(1, ids), make_column(2, pairs)};
  run(limits_of(), &s);
  const auto values = values_of<std::int64_t>(s.mesh.point_columns[0]);
  const auto bytes = values_of<std::uint8_t>(s.mesh.point_columns[1]);
  std::set<std::int64_t> seen;
  double furthest = 0;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const std::int64_t id = (values[v] - 1'000'000) / 7;
    ASSERT_EQ(values[v], 1'000'000 + 7 * id);
    ASSERT_LT(static_cast<std::size_t>(id), before.vertex_count());
    EXPECT_TRUE(seen.insert(id).second) << "a value twice";
    EXPECT_EQ(bytes[2 * v], id % 251);
    EXPECT_EQ(bytes[2 * v + 1], 9);
    const auto was = at(before, static_cast<VertexId>(id)), is = at(s.mesh, v);
    furthest = std::max(furthest, std::hypot(was[0] - is[0], was[1] - is[1], was[2] - is[2]));
    if ((s.mesh.marks[v] & kOnBoundary) != 0) {
      EXPECT_EQ(id, s.mesh.point_ids[v]);
    }
  }
  EXPECT_LT(furthest, 4);  // of 9: the nearest of those that were fused
}

// Every tetrahedron that is left has the corners that it had, each of them fused to the same vertex
// wherever it was.
TEST(FuseRound, CellColumnsFollowTheirTetrahedra) {
  Steered s = steered(five_split_cube(9, 0.2, 6), smooth);
  Vector<float> halves;
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    halves.insert(halves.end(), {static_cast<float>(t) / 2, static_cast<float>(t)});
  }
  s.mesh.cell_columns.push_back(make_column(2, halves));
  testing::number_tets(&s.mesh);
  const WorkMesh<double> before = s.mesh;
  run(limits_of(), &s);
  const auto numbers = testing::tet_numbers(s.mesh);
  const auto rows = values_of<float>(s.mesh.cell_columns[0]);
  std::map<VertexId, VertexId> became;
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    if (t > 0) {
      EXPECT_LT(numbers[t - 1], numbers[t]);
    }
    EXPECT_EQ(rows[2 * t], static_cast<float>(numbers[t]) / 2);
    EXPECT_EQ(rows[2 * t + 1], static_cast<float>(numbers[t]));
    const Tet& old = before.tets[numbers[t]];
    for (std::size_t c = 0; c < 4; ++c) {
      const VertexId now = s.mesh.point_ids[s.mesh.tets[t][c]];
      EXPECT_EQ(became.try_emplace(old[c], now).first->second, now);
      if ((before.marks[old[c]] & kOnBoundary) != 0) {
        EXPECT_EQ(now, old[c]);
      }
    }
  }
}

// The weights of all quadrics are the four determinants of each tetrahedron, before and after.
TEST(FuseRound, QuadricsAddUp) {
  Steered s = steered(five_split_cube(8, 0.2, 8), smooth);
  const auto weight = [&] {
    double sum = 0;
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      sum += s.mesh.quadrics[v * s.mesh.quadric_width + kQuadricW];
    }
    return sum;
  };
  const double expected = 4 * 6 * 512 * kUnit * kUnit * kUnit;
  EXPECT_NEAR(weight() / expected, 1, 1e-6);
  run(limits_of(), &s);
  EXPECT_NEAR(weight() / expected, 1, 1e-5);
}

TEST(FuseRound, TheScaleOfAMeshDoesNotMatter) {
  Steered s = steered(five_split_cube(9, 0.2, 4), smooth);
  const Steered fresh = s;
  run(limits_of(3e-3), &s);
  for (const double scale : {0x1p-20, 0x1p20}) {
    Steered other = fresh;
    for (Vec3<double>& p : other.mesh.positions) p = {p.x * scale, p.y * scale, p.z * scale};
    begin_quadrics(other.fields(), kUnit / scale, &other.mesh);
    FuseLimits limits = limits_of(3e-3);
    limits.unit /= scale;
    run(limits, &other);
    expect_same(s.mesh, other.mesh, scale);
  }
}

// Nor does that of a field.
TEST(FuseRound, TheScaleOfAFieldDoesNotMatter) {
  Steered s = steered(five_split_cube(8, 0.2, 4), smooth);
  Steered other = s;
  for (double& x : other.mesh.steering) x *= 0x1p30;
  other.field.range *= 0x1p30;
  begin_quadrics(other.fields(), kUnit, &other.mesh);
  run(limits_of(3e-3), &s);
  run(limits_of(3e-3), &other);
  for (double& x : s.mesh.steering) x *= 0x1p30;
  expect_same(s.mesh, other.mesh);
}

TEST(FuseRound, RemembersNothingOfOtherMeshes) {
  FuseRound<double> old;
  for (const std::uint32_t n : {9, 5, 8}) {
    Steered s = steered(five_split_cube(n, 0.2, n), n == 5 ? rough : smooth);
    Steered fresh = s;
    for (const double threshold : {1e-3, 1e-1}) {
      FuseLimits limits = limits_of(threshold);
      limits.quota = n == 8 ? 300 : limits.quota;
      const FuseStatistics a = old.run(limits, s.fields(), &s.mesh);
      const FuseStatistics b = run(limits, &fresh);
      EXPECT_EQ(a.pass.fused, b.pass.fused);
      EXPECT_EQ(a.pass.rejected, b.pass.rejected);
      EXPECT_EQ(a.costs, b.costs);
      expect_same(s.mesh, fresh.mesh);
    }
  }
}

// Many times on the way, so that nobody waits long for the end, and the round is the same.
TEST(FuseRound, TellsAWatcherWhatGoesAndEndsWhenItThrows) {
  struct Enough {};
  Steered s = steered(five_split_cube(20, 0.2, 3), smooth);
  Steered unwatched = s, ended = s;
  const FuseStatistics expected = run(limits_of(1e-1), &unwatched);
  FuseRound<double> round;
  std::uint64_t calls = 0, gone = 0, most = 0;
  round.watch([&](std::uint64_t more) {
    ++calls;
    gone += more;
    most = std::max(most, more);
  });
  round.run(limits_of(1e-1), s.fields(), &s.mesh);
  EXPECT_EQ(gone, expected.pass.tets_before - expected.pass.tets_after);
  EXPECT_GT(calls, 10u);
  EXPECT_LT(most, gone / 2);
  EXPECT_LE(most, 64 * 16);  // a fusion takes ten or so
  expect_same(s.mesh, unwatched.mesh);
  gone = 0;
  round.watch([&](std::uint64_t more) {
    gone += more;
    if (gone > 0) throw Enough();
  });
  EXPECT_THROW(round.run(limits_of(1e-1), ended.fields(), &ended.mesh), Enough);
  EXPECT_LE(gone, most);
}

// And asked again in the next round: or the reason would be that it costs too much.
TEST(FuseRound, WhatHasFailedIsRemembered) {
  Steered s = steered(five_split_cube(8, 0.4, 5), smooth);
  FuseLimits limits = limits_of(1e-3);
  limits.min_quality = 0.5;
  FuseRound<double> round;
  const auto failed = [&] {
    const std::size_t row = s.mesh.quadric_width;
    std::uint64_t count = 0;
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      count += s.mesh.quadrics[(v + 1) * row - 1] < 0 ? 1 : 0;
    }
    return count;
  };
  for (int i = 0; i < 3; ++i) {
    const FuseStatistics statistics = round.run(limits, s.fields(), &s.mesh, nullptr);
    const std::uint64_t for_shapes =
        rejected(statistics, Reject::kFlip) + rejected(statistics, Reject::kQuality);
    EXPECT_GT(for_shapes, 20u);
    EXPECT_EQ(failed(), for_shapes);
  }
}

TEST(FuseRound, ALookChangesNothingButWhatIsKnown) {
  Steered s = steered(five_split_cube(8, 0.2, 5), smooth);
  const WorkMesh<double> before = s.mesh;
  FuseRound<double> round;
  const FuseStatistics statistics = round.look(limits_of(1e-3), s.fields(), &s.mesh);
  EXPECT_EQ(statistics.pass.fused, 0u);
  EXPECT_EQ(statistics.pass.tets_after, before.tets.size());
  EXPECT_EQ(std::accumulate(statistics.costs.begin(), statistics.costs.end(), 0ULL), 7u * 7 * 7);
  const std::uint32_t row = before.quadric_width;
  for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
    const bool is_inner = (before.marks[v] & kOnBoundary) == 0;
    EXPECT_EQ(s.mesh.quadrics[(v + 1) * row - 1] > 0, is_inner);
    s.mesh.quadrics[(v + 1) * row - 1] = 0;
  }
  expect_same(s.mesh, before);
}

}  // namespace
}  // namespace tetfusion
