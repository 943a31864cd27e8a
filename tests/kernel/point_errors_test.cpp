#include "kernel/fields/point_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "kernel/fuse/fuse_round.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "support/fuse_meshes.h"
#include "support/point_deviation.h"

namespace tetfusion {
namespace {

using testing::expect_same_domain;
using testing::expect_whole;
using testing::five_split_cube;
using testing::kuhn_box;
using testing::kUnit;
using testing::limits_of;
using testing::linear;
using testing::range_of;
using testing::rejected;
using testing::rough;
using testing::run;
using testing::smooth;
using testing::Steered;
using testing::steered;
using testing::worst_deviation;

FuseLimits bounded(double max_error, double threshold = 1) {
  FuseLimits limits = limits_of(threshold);
  limits.max_error = max_error;
  return limits;
}

// Has the mesh's one value a vertex followed by others, which more(position) gives.
template <class More>
void add_values(const More& more, WorkMesh<double>* mesh) {
  Vector<double> steering;
  for (std::size_t v = 0; v < mesh->vertex_count(); ++v) {
    steering.push_back(mesh->steering[v]);
    for (const double value : more(mesh->positions[v])) steering.push_back(value);
  }
  mesh->steering = std::move(steering);
  mesh->steering_width = static_cast<std::uint32_t>(mesh->steering.size() / mesh->vertex_count());
}

// Every point of the original is a vertex where it was, with its value, or a removed one, once, in
// a tetrahedron that holds it.
template <class Real>
void expect_all_points(const WorkMesh<Real>& mesh, const WorkMesh<Real>& original) {
  using Row = std::array<double, 4>;
  const auto row = [](const Vec3<Real>& p, double value) -> Row { return {p.x, p.y, p.z, value}; };
  std::multiset<Row> expected, found;
  for (std::size_t v = 0; v < original.vertex_count(); ++v) {
    expected.insert(row(original.positions[v], original.steering[v]));
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.marks[v] & kMoved) == 0) found.insert(row(mesh.positions[v], mesh.steering[v]));
  }
  const RemovedPoints<Real>& removed = mesh.removed;
  ASSERT_EQ(removed.first.size(), mesh.tets.size());
  std::size_t listed = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::uint32_t i = removed.first[t]; i != kNoPoint; i = removed.next[i]) {
      ++listed;
      found.insert(row(removed.positions[i], removed.values[i]));
      const auto w = testing::weights_in(mesh, mesh.tets[t], removed.positions[i]);
      EXPECT_GE(*std::min_element(w.begin(), w.end()), -1e-12);
    }
  }
  EXPECT_EQ(listed, removed.size());
  EXPECT_EQ(found, expected);
}

// The centre of an icosahedron may leave its value behind if that is within the bound.
TEST(PointErrors, ABoundIsABound) {
  const auto far_off = [](double x, double y, double z) {
    return x * x + y * y + z * z < 0.1 ? 1.0 : 0.0;
  };
  for (const bool allowed : {false, true}) {
    Steered s = steered(testing::icosahedron_ball(), far_off);
    const FuseStatistics statistics = run(bounded(allowed ? 1.001 : 0.999, 1e9), &s);
    EXPECT_EQ(statistics.pass.fused, allowed ? 1u : 0u);
    ASSERT_EQ(s.mesh.removed.size(), allowed ? 1u : 0u);
    if (allowed) {
      EXPECT_EQ(s.mesh.removed.values[0], 1.0);
    }
  }
}

TEST(PointErrors, NothingIsRememberedWithoutABound) {
  Steered s = steered(five_split_cube(6, 0.2, 3), smooth);
  EXPECT_GT(run(limits_of(), &s).pass.fused, 0u);
  EXPECT_FALSE(s.mesh.removed.wanted());
}

TEST(PointErrors, HoldAtEveryPointAfterEveryRound) {
  std::uint64_t refused = 0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    for (const auto f : {smooth, rough, linear}) {
      for (const double max_error : {1e-3, 1e-2, 5e-2, 0.5}) {
        Steered s =
            steered(seed == 1 ? kuhn_box(6, 5, 6, 0.15, seed) : five_split_cube(7, 0.2, seed), f);
        const WorkMesh<double> before = s.mesh;
        FuseRound<double> round;
        for (const double threshold : {1e-6, 1e-4, 1e-2, 1.0}) {
          const FuseStatistics statistics =
              round.run(bounded(max_error, threshold), s.fields(), &s.mesh);
          refused += rejected(statistics, Reject::kDeviation);
          EXPECT_LE(worst_deviation(before, s.mesh, s.field), max_error * (1 + 1e-9));
          expect_all_points(s.mesh, before);
        }
        expect_same_domain(s.mesh, before);
        expect_whole(s.mesh);
        EXPECT_TRUE(10 * s.mesh.tets.size() < 6 * before.tets.size() || max_error < 0.3);
      }
    }
  }
  EXPECT_GT(refused, 500u);
}

TEST(PointErrors, ALinearFieldAllowsAllThatGeometryDoes) {
  Steered free = steered(five_split_cube(8, 0.2, 5), linear);
  Steered bound = free;
  const WorkMesh<double> before = free.mesh;
  run(limits_of(1), &free);
  EXPECT_EQ(rejected(run(bounded(1e-6), &bound), Reject::kDeviation), 0u);
  EXPECT_EQ(bound.mesh.tets, free.mesh.tets);
  EXPECT_LT(worst_deviation(before, bound.mesh, bound.field), 1e-12);
}

// In an array of single precision, with coordinates in single precision: what counts is what is
// written.
TEST(PointErrors, HoldForWhatIsWritten) {
  WorkMesh<float> mesh = testing::to_float_work_mesh(five_split_cube(7, 0.2, 3));
  testing::steer_by([](double x, double y, double z) { return float(100 + smooth(x, y, z)); },
                    &mesh);
  const Vector<float> written(mesh.steering.begin(), mesh.steering.end());
  mesh.point_columns = {testing::make_column(1, written)};
  SteeringField field = range_of(mesh);
  field.column = 0;
  begin_quadrics({&field, 1}, kUnit, &mesh);
  const WorkMesh<float> before = mesh;
  FuseRound<float> round;
  for (const double threshold : {1e-5, 1e-3, 1.0}) {
    round.run(bounded(0.02, threshold), {&field, 1}, &mesh);
    const auto values = testing::values_of<float>(mesh.point_columns[0]);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) EXPECT_EQ(mesh.steering[v], values[v]);
    EXPECT_LE(worst_deviation(before, mesh, field), 0.02);
    expect_all_points(mesh, before);
  }
  EXPECT_LT(mesh.tets.size(), 3 * before.tets.size() / 4);
}

// Each field has the bound that is its own; the error of a vector is a length.
TEST(PointErrors, FieldsHaveBoundsOfTheirOwn) {
  Steered s = steered(five_split_cube(7, 0.2, 3), smooth);
  WorkMesh<double>& mesh = s.mesh;
  add_values(
      [](const Vec3<double>& p) {
        return std::array{std::cos(p.y / 2), std::sin(p.x / 2), std::cos(p.z / 2)};
      },
      &mesh);
  std::array<SteeringField, 2> fields{s.field, {1, 3, std::sqrt(8.0), {}}};
  const auto errors = [&](std::optional<double> own, double max_error) {
    fields[0].tolerance = own;
    WorkMesh<double> work = mesh;
    begin_quadrics(fields, kUnit, &work);
    const FuseStatistics statistics = FuseRound<double>().run(bounded(max_error), fields, &work);
    EXPECT_GT(statistics.pass.fused, 0u);
    return std::array{worst_deviation(mesh, work, fields[0]),
                      worst_deviation(mesh, work, fields[1])};
  };
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto both = errors({}, 0.02);
  EXPECT_LE(std::max(both[0], both[1]), 0.02);
  const auto apart = errors(0.004, 0.04);
  EXPECT_LE(apart[0], 0.004);
  EXPECT_LE(apart[1], 0.04);
  EXPECT_GT(apart[1], 0.02);
  const auto one = errors(0.01, kNone);
  EXPECT_LE(one[0], 0.01);
  EXPECT_GT(one[1], 0.02);
}

// A vertex that is moved for the sake of one field would leave another one behind.
TEST(PointErrors, AFieldWithoutABoundStaysWhatItIs) {
  Steered s = steered(five_split_cube(9, 0.2, 3), smooth);
  WorkMesh<double>& mesh = s.mesh;
  add_values([](const Vec3<double>& p) { return std::array{linear(p.x, p.y, p.z)}; }, &mesh);
  std::array<SteeringField, 2> fields{s.field, {1, 1, 5, {}}};
  fields[0].tolerance = 0.005;
  begin_quadrics(fields, kUnit, &mesh);
  const FuseStatistics statistics = FuseRound<double>().run(limits_of(1e-2), fields, &mesh);
  EXPECT_GT(rejected(statistics, Reject::kDeviation), 0u);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3<double>& p = mesh.positions[v];
    EXPECT_NEAR(mesh.steering[2 * v + 1], linear(p.x, p.y, p.z), 1e-5);
  }
}

// What a round allows is a bound for fields that have one, and for no others.
TEST(PointErrors, ARoundMayAllowLess) {
  const Steered fresh = steered(five_split_cube(7, 0.2, 3), smooth);
  for (const double bound : {0.05, std::numeric_limits<double>::infinity()}) {
    Steered s = fresh;
    FuseLimits limits = bounded(bound);
    limits.error_now = 0.01;
    run(limits, &s);
    const double worst = worst_deviation(fresh.mesh, s.mesh, s.field);
    EXPECT_EQ(worst <= 0.01, bound < 1) << worst;
    EXPECT_EQ(s.mesh.removed.wanted(), bound < 1);
  }
}

TEST(PointErrors, TheScaleOfAMeshDoesNotMatter) {
  const Steered fresh = steered(five_split_cube(6, 0.2, 3), smooth);
  Steered expected = fresh;
  run(bounded(0.01), &expected);
  for (const int exponent : {-20, 20}) {
    Steered s = fresh;
    const double scale = std::ldexp(1.0, exponent);
    for (Vec3<double>& p : s.mesh.positions) p = {p.x * scale, p.y * scale, p.z * scale};
    begin_quadrics(s.fields(), kUnit / scale, &s.mesh);
    FuseLimits limits = bounded(0.01);
    limits.unit = kUnit / scale;
    run(limits, &s);
    EXPECT_EQ(s.mesh.tets, expected.mesh.tets);
    EXPECT_EQ(s.mesh.steering, expected.mesh.steering);
    EXPECT_EQ(s.mesh.removed.first, expected.mesh.removed.first);
  }
}

// Values that are not allowed are moved to ones that are, and no further.
TEST(PointErrors, ValuesAreMovedAsLittleAsItTakes) {
  Steered s = steered(five_split_cube(4), linear);
  const FuseLimits limits = limits_of();
  testing::count_incidence(&s.mesh);
  LiveBalls balls;
  balls.reset(s.mesh.vertex_count(), s.mesh.tets);
  FuseCavity<double> cavity;
  cavity.begin(&s.mesh, &balls, 0, limits.unit);
  PointErrors<double> errors;
  const double bound = 0.01;
  errors.begin(s.fields(), {.max_error = bound, .unit = limits.unit}, &s.mesh, &balls);
  std::size_t tried = 0;
  for (const Tet& tet : s.mesh.tets) {
    const VertexId v = tet[0], partner = tet[1];
    if (((s.mesh.marks[v] | s.mesh.marks[partner]) & kOnBoundary) != 0) continue;
    const Vec3<double>&a = s.mesh.positions[v], &b = s.mesh.positions[partner];
    const Vec3<double> middle{(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
    if (cavity.collect(v, partner, false, middle)) continue;
    ++tried;
    const Joining<double> joining{v, partner, false, middle, cavity.affected(), cavity.deleted()};
    const double best = linear(middle.x, middle.y, middle.z);
    const double limit = bound * s.field.range;
    const auto with = [&](double value) {
      std::array<double, 1> low{best - 9}, high{best + 9}, values{value};
      EXPECT_TRUE(errors.allows(joining, low, high, values));
      return values[0];
    };
    EXPECT_EQ(with(best), best);
    EXPECT_GT(with(best + 8), best + 0.99 * limit);  // the two ends are the points in the way
    EXPECT_LT(with(best - 8), best - 0.99 * limit);
    std::array<double, 1> low{best + 8}, high{best + 9}, values{best + 8};
    EXPECT_FALSE(errors.allows(joining, low, high, values));
  }
  EXPECT_GT(tried, 0u);
}

// With room for it a vertex gets the value of the least squares, by weights that are found
// otherwise; with less, one that is as near to it as the bound allows.
TEST(PointErrors, RefitSquares) {
  Steered s = steered(five_split_cube(7, 0.2, 3), smooth);
  run(bounded(0.01, 1e-4), &s);
  testing::count_incidence(&s.mesh);
  LiveBalls balls;
  balls.reset(s.mesh.vertex_count(), s.mesh.tets);
  std::size_t least = 0, bounded_ones = 0;
  for (const double bound : {10.0, 0.01}) {
    PointErrors<double> errors;
    errors.begin(s.fields(), {.max_error = bound, .unit = kUnit}, &s.mesh, &balls);
    for (VertexId v = 0; v < s.mesh.vertex_count(); ++v) {
      if ((s.mesh.marks[v] & (kMoved | kOnBoundary)) != kMoved) continue;
      struct Say {
        double weight, error;
      };
      std::vector<Say> points;
      const auto ball = balls.of(v, s.mesh.incidence[v], s.mesh.tets);
      double low = s.mesh.steering[v], high = low;
      for (const std::uint32_t entry : ball) {
        const Tet& tet = s.mesh.tets[entry >> 2];
        for (auto i = s.mesh.removed.first[entry >> 2]; i != kNoPoint; i = s.mesh.removed.next[i]) {
          const auto w = testing::weights_in(s.mesh, tet, s.mesh.removed.positions[i]);
          double error = -s.mesh.removed.values[i];
          for (std::size_t c = 0; c < 4; ++c) error += w[c] * s.mesh.steering[tet[c]];
          points.push_back({w[entry & 3u], error});
          low = std::min(low, s.mesh.removed.values[i]);
          high = std::max(high, s.mesh.removed.values[i]);
        }
      }
      double sum = 0, squares = 0;
      for (const Say& p : points) {
        sum += p.weight * p.error;
        squares += p.weight * p.weight;
      }
      if (squares < 1.0 / 32) continue;
      const double before = s.mesh.steering[v];
      const double best = std::clamp(before - sum / squares, low, high);
      std::array<double, 1> value{};
      const bool changes = errors.refit(v, ball, value);
      if (bound > 1) {
        EXPECT_NEAR(value[0], best, 1e-12);
        ++least;
        continue;
      }
      if (!changes) continue;
      EXPECT_LE(std::abs(value[0] - best), std::abs(before - best) * (1 + 1e-12));
      for (const Say& p : points) {
        EXPECT_LE(std::abs(p.error + p.weight * (value[0] - before)), bound * s.field.range);
      }
      if (std::abs(value[0] - best) > 1e-9) ++bounded_ones;
    }
  }
  EXPECT_GT(least, 20u);
  EXPECT_GT(bounded_ones, 0u);
}

// Where its values are, and a point is right in the middle of a kink, the vertex goes there.
TEST(PointErrors, AVertexGoesToWhereTheFieldBends) {
  const double bend = 0.3;
  const auto kinked = [&](double x, double, double) { return std::abs(x - bend); };
  Steered s = steered(testing::icosahedron_ball(), kinked);
  testing::count_incidence(&s.mesh);
  const auto centre = static_cast<VertexId>(
      std::ranges::find_if(s.mesh.marks, [](auto m) { return (m & kOnBoundary) == 0; }) -
      s.mesh.marks.begin());
  s.mesh.marks[centre] |= kMoved;
  LiveBalls balls;
  balls.reset(s.mesh.vertex_count(), s.mesh.tets);
  PointErrors<double> errors;
  errors.begin(s.fields(), {.max_error = 1, .unit = kUnit}, &s.mesh, &balls);
  // One removed point next to each face's middle.
  for (TetId t = 0; t < s.mesh.tets.size(); ++t) {
    Vec3<double> p{0, 0, 0};
    for (const VertexId v : s.mesh.tets[t]) {
      const double share = v == centre ? 0.4 : 0.2;
      p.x += share * s.mesh.positions[v].x;
      p.y += share * s.mesh.positions[v].y;
      p.z += share * s.mesh.positions[v].z;
    }
    const auto i = s.mesh.removed.add(1, 1);
    s.mesh.removed.positions[i] = p;
    s.mesh.removed.values[i] = kinked(p.x, p.y, p.z);
    s.mesh.removed.push(t, i);
  }
  const auto ball = balls.of(centre, s.mesh.incidence[centre], s.mesh.tets);
  std::array<double, 1> values{};
  if (errors.refit(centre, ball, values)) s.mesh.steering[centre] = values[0];
  const auto place = errors.wished_position();
  ASSERT_TRUE(place);
  EXPECT_EQ(s.mesh.positions[centre].x, 0);
  EXPECT_NEAR(place->x, bend, 0.05);
  EXPECT_LT(std::abs(place->y) + std::abs(place->z), 0.05);
  ASSERT_TRUE(errors.refit_at(*place, ball, values));
  EXPECT_LT(values[0], 0.05);
  errors.apply();
  s.mesh.positions[centre] = *place;
  s.mesh.steering[centre] = values[0];
  // Each is in the list of a tetrahedron that holds it.
  std::size_t listed = 0;
  for (std::size_t t = 0; t < s.mesh.tets.size(); ++t) {
    for (auto i = s.mesh.removed.first[t]; i != kNoPoint; i = s.mesh.removed.next[i]) {
      const auto w = testing::weights_in(s.mesh, s.mesh.tets[t], s.mesh.removed.positions[i]);
      EXPECT_GE(*std::ranges::min_element(w), -1e-12);
      ++listed;
    }
  }
  EXPECT_EQ(listed, s.mesh.removed.size());
}

// What a round leaves under a bound goes on further than it would with the values of the fusions
// alone, and is nearer to the original.
TEST(PointErrors, RoundsRefitWhereABoundRefuses) {
  const auto squares_of = [](const WorkMesh<double>& mesh) {
    double squares = 0;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      for (auto i = mesh.removed.first[t]; i != kNoPoint; i = mesh.removed.next[i]) {
        const auto w = testing::weights_in(mesh, mesh.tets[t], mesh.removed.positions[i]);
        double error = -mesh.removed.values[i];
        for (std::size_t c = 0; c < 4; ++c) error += w[c] * mesh.steering[mesh.tets[t][c]];
        squares += error * error;
      }
    }
    return squares;
  };
  Steered fresh = steered(five_split_cube(9, 0.2, 3), smooth);
  // With a log, which wants the tetrahedra's numbers, values stay as fusions leave them.
  Column numbers{ValueType::kUInt32, 1, {}};
  numbers.resize(fresh.mesh.tets.size());
  for (TetId t = 0; t < fresh.mesh.tets.size(); ++t) {
    std::memcpy(numbers.rows.data() + t * sizeof t, &t, sizeof t);
  }
  fresh.mesh.cell_columns.push_back(std::move(numbers));
  Steered kept = fresh, refitted = fresh;
  FusionLog log;
  FuseRound<double>().run(bounded(0.005, 1e-2), kept.fields(), &kept.mesh, &log);
  run(bounded(0.005, 1e-2), &refitted);
  EXPECT_EQ(refitted.mesh.tets, kept.mesh.tets);
  EXPECT_LT(squares_of(refitted.mesh), 0.97 * squares_of(kept.mesh));
}

}  // namespace
}  // namespace tetfusion
