#include "kernel/fit/value_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "support/meshes.h"
#include "support/point_deviation.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

// Points inside tetrahedra, with the values of a function there.
template <class Real>
struct Samples {
  Vector<Vec3<Real>> positions, starts;
  Vector<double> values;

  template <class F>
  void add(const Vec3<Real>& p, F&& f) {
    positions.push_back(p);
    values.push_back(f(p));
  }
  const std::byte* rows() const { return reinterpret_cast<const std::byte*>(values.data()); }
};

// `per_tet` points somewhere in each tetrahedron, in the order of these.
template <class Real, class F>
Samples<Real> sample(const WorkMesh<Real>& mesh, std::size_t per_tet, F&& f) {
  Samples<Real> out;
  for (std::size_t i = 0; i < per_tet * mesh.tets.size(); ++i) {
    std::array<double, 4> w{};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += w[k] = 0.05 + testing::uniform(17, 4 * i + k);
    Vec3<double> p{};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3<Real>& q = mesh.positions[mesh.tets[i / per_tet][k]];
      p = {p.x + w[k] / sum * q.x, p.y + w[k] / sum * q.y, p.z + w[k] / sum * q.z};
    }
    out.add({static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)}, f);
  }
  return out;
}

// The only interior vertex, 0, is a new one.
WorkMesh<double> ball(double value) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::icosahedron_ball());
  testing::steer_by([](double, double, double) { return 1.0; }, &mesh);
  mesh.steering[0] = value;
  mesh.marks[0] |= kMoved;
  return mesh;
}

// Fits the mesh's steering values, as its only column, to every step-th of the points. Returns the
// vertices whose values are others then.
template <class Real>
Vector<VertexId> fit_with(ValueFit<Real>* tool, const Samples<Real>& samples, WorkMesh<Real>* mesh,
                          std::uint64_t first = 0, std::uint64_t step = 1) {
  mesh->point_columns = {testing::make_column(mesh->steering_width, mesh->steering)};
  const std::uint32_t column_in_mesh = 0;
  TetWalk<Real> walk;
  walk.begin(*mesh);
  tool->begin(mesh, {&column_in_mesh, 1}, &walk);
  tool->add({samples.positions, samples.starts}, first, step);
  tool->fit([&](std::size_t column, const auto& use) {
    EXPECT_EQ(column, 0u);
    use(samples.rows());
  });
  const Vector<double> before = mesh->steering;
  std::memcpy(mesh->steering.data(), mesh->point_columns[0].rows.data(),
              before.size() * sizeof(double));
  Vector<VertexId> changed;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (mesh->steering[i] == before[i]) continue;
    changed.push_back(static_cast<VertexId>(i / mesh->steering_width));
  }
  return changed;
}

Vector<VertexId> fit(const Samples<double>& samples, WorkMesh<double>* mesh) {
  ValueFit<double> tool;
  return fit_with(&tool, samples, mesh);
}

double wave(double x) { return 3 + std::sin(0.2 * x); }

// A box with some new vertices, whose values are off by up to 0.2.
WorkMesh<double> rough_box() {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(6, 0.15, 8));
  testing::steer_by([](double x, double, double) { return wave(x); }, &mesh);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.marks[v] != 0 || testing::uniform(3, v) < 0.5) continue;
    mesh.marks[v] |= kMoved;
    mesh.steering[v] += 0.4 * (testing::uniform(4, v) - 0.5);
  }
  return mesh;
}

// Errors at points with these values, found in all tetrahedra.
Vector<double> errors_at(const Samples<double>& samples, std::size_t per_tet,
                         const WorkMesh<double>& mesh) {
  Vector<double> errors;
  SteeringField field;
  field.range = 1;
  for (std::size_t i = 0; i < samples.values.size(); ++i) {
    errors.push_back(testing::deviation_in(mesh, mesh.tets[i / per_tet], samples.positions[i],
                                           &samples.values[i], field));
  }
  return errors;
}

double sum_of_squares(const Vector<double>& errors) {
  double sum = 0;
  for (const double e : errors) sum += e * e;
  return sum;
}
double largest(const Vector<double>& errors) {
  return *std::max_element(errors.begin(), errors.end());
}

TEST(ValueFit, APointInTheVertexHasItsWay) {
  WorkMesh<double> mesh = ball(1);
  Samples<double> samples;
  samples.add(mesh.positions[0], [](auto) { return 4.0; });
  EXPECT_EQ(fit(samples, &mesh), Vector<VertexId>{0});
  EXPECT_EQ(mesh.steering[0], 4);
}

TEST(ValueFit, PointsHalfwayAreMetByTheVertex) {
  WorkMesh<double> mesh = ball(1);
  Samples<double> samples;
  // With 1 at the corners outside, 3 in the middle makes 2 halfway. One far value allows for 3.
  for (std::size_t v = 1; v < mesh.vertex_count(); ++v) {
    const Vec3<double>& p = mesh.positions[v];
    samples.add({p.x / 2, p.y / 2, p.z / 2}, [](auto) { return 2.0; });
  }
  fit(samples, &mesh);
  EXPECT_EQ(mesh.steering[0], 2);  // not beyond what the original has round it
  samples.add({0.01, 0.01, 0.01}, [](auto) { return 3.0; });
  fit(samples, &mesh);
  EXPECT_NEAR(mesh.steering[0], 3, 0.1);
}

TEST(ValueFit, OnlyNewVerticesThatNobodyElseHasMove) {
  const std::uint8_t fixed[] = {0, kMoved | kOnInterface, kMoved | kLocked};
  for (const std::uint8_t marks : fixed) {
    WorkMesh<double> mesh = ball(1);
    mesh.marks[0] = marks;
    Samples<double> samples;
    samples.add(mesh.positions[0], [](auto) { return 4.0; });
    EXPECT_TRUE(fit(samples, &mesh).empty());
    EXPECT_EQ(mesh.steering[0], 1);
  }
}

TEST(ValueFit, PointsOutsideDoNotCount) {
  WorkMesh<double> mesh = ball(1);
  Samples<double> samples;
  samples.add({2, 0, 0}, [](auto) { return 4.0; });
  samples.add({0, -3, 0.5}, [](auto) { return 4.0; });
  EXPECT_TRUE(fit(samples, &mesh).empty());
  samples.add(mesh.positions[0], [](auto) { return 5.0; });  // found after these, too
  fit(samples, &mesh);
  EXPECT_EQ(mesh.steering[0], 5);
}

// Over a gap no walk gets, and from a tetrahedron without volume none gets anywhere.
TEST(ValueFit, PointsAreFoundInPartsThatDoNotTouch) {
  Geometry two = testing::make_mesh({{4, 0, 0}, {4, 0, 0}, {4, 0, 0}, {4, 0, 0}}, {{0, 1, 2, 3}});
  const Geometry one = testing::icosahedron_ball();
  auto& points = std::get<Vector<Vec3<double>>>(two.points);
  for (const double x : {0.0, 8.0}) {
    const auto first = static_cast<VertexId>(points.size());
    for (VertexId v = 0; v < point_count(one.points); ++v) {
      const testing::Point p = testing::point(one, v);
      points.push_back({p.x + x, p.y, p.z});
    }
    for (Tet tet : one.tets) {
      for (VertexId& v : tet) v += first;
      two.tets.push_back(tet);
    }
  }
  WorkMesh<double> mesh = testing::to_work_mesh(std::move(two));
  testing::steer_by([](double, double, double) { return 1.0; }, &mesh);
  Samples<double> samples;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3<double>& p = mesh.positions[v];
    if (p.y != 0 || p.z != 0 || p.x == 4) continue;
    mesh.marks[v] |= kMoved;
    samples.add(p, [](const Vec3<double>& x) { return 2 + x.x; });
  }
  ASSERT_EQ(fit(samples, &mesh).size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const VertexId centre = static_cast<VertexId>(i == 0 ? 4 : 4 + point_count(one.points));
    EXPECT_EQ(mesh.steering[centre], samples.values[i]) << i;
  }
}

TEST(ValueFit, ErrorsBecomeSmaller) {
  WorkMesh<double> mesh = rough_box();
  const auto samples = sample(mesh, 3, [](const Vec3<double>& p) { return wave(p.x); });
  const Vector<double> before = errors_at(samples, 3, mesh);
  const WorkMesh<double> as_it_was = mesh;
  fit(samples, &mesh);
  const Vector<double> after = errors_at(samples, 3, mesh);
  EXPECT_LT(sum_of_squares(after), 0.5 * sum_of_squares(before));
  EXPECT_LT(largest(after), 0.8 * largest(before));
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.marks[v] & kMoved) != 0) continue;
    EXPECT_EQ(mesh.steering[v], as_it_was.steering[v]);
  }
}

TEST(ValueFit, TheLargestValuesThatThereAreStayFinite) {
  WorkMesh<double> mesh = rough_box();
  const double most = std::numeric_limits<double>::max();
  std::size_t next = 0;
  const auto samples = sample(mesh, 3, [&](const Vec3<double>&) {
    return testing::uniform(9, next++) < 0.5 ? most : -most;
  });
  mesh.steering.assign(mesh.steering.size(), 0);
  fit(samples, &mesh);
  for (const double value : mesh.steering) EXPECT_TRUE(std::isfinite(value));
}

TEST(ValueFit, ALinearFieldStays) {
  WorkMesh<double> mesh = rough_box();
  const auto f = [](double x, double y, double z) { return 1e5 + 2 * x - 3 * y + 0.5 * z; };
  testing::steer_by(f, &mesh);
  const WorkMesh<double> before = mesh;
  fit(sample(mesh, 2, [&](const Vec3<double>& p) { return f(p.x, p.y, p.z); }), &mesh);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(mesh.steering[v], before.steering[v], 1e-9) << v;
  }
}

TEST(ValueFit, ComponentsDoNotKnowEachOther) {
  WorkMesh<double> one = rough_box();
  WorkMesh<double> two = one;
  two.steering_width = 2;
  two.steering.clear();
  for (const double value : one.steering) two.steering.insert(two.steering.end(), {-7, value});
  const auto samples = sample(one, 3, [](const Vec3<double>& p) { return wave(p.x); });
  fit(samples, &one);
  Samples<double> both = samples;
  both.values.clear();
  for (const double value : samples.values) both.values.insert(both.values.end(), {-7, value});
  fit(both, &two);
  for (std::size_t v = 0; v < one.vertex_count(); ++v) {
    EXPECT_EQ(two.steering[2 * v], -7);
    EXPECT_EQ(two.steering[2 * v + 1], one.steering[v]);
  }
}

// Each as if it were alone: columns of other types, and what is no number here and there.
TEST(ValueFit, FitsTheColumnsThatAreNamed) {
  WorkMesh<double> one = rough_box();
  const auto samples = sample(one, 3, [](const Vec3<double>& p) { return wave(p.x); });
  WorkMesh<double> many = one;
  Vector<float> singles(one.steering.begin(), one.steering.end());
  const Vector<std::int32_t> integers(one.vertex_count(), 3);
  many.point_columns = {testing::make_column(1, integers), testing::make_column(1, singles),
                        testing::make_column(1, one.steering)};
  const Vector<float> single_goals(samples.values.begin(), samples.values.end());
  Vector<double> goals = samples.values;
  Samples<double> finite;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    if (i % 5 == 0) {
      goals[i] = i % 2 == 0 ? std::nan("") : std::numeric_limits<double>::infinity();
    } else {
      finite.positions.push_back(samples.positions[i]);
      finite.values.push_back(goals[i]);
    }
  }
  const std::byte* const columns[] = {reinterpret_cast<const std::byte*>(single_goals.data()),
                                      reinterpret_cast<const std::byte*>(goals.data())};
  // In two pieces.
  const std::size_t half = goals.size() / 2;
  const std::span<const Vec3<double>> points = samples.positions;
  ValueFit<double> tool;
  const std::uint32_t fitted[] = {1, 2};
  TetWalk<double> walk;
  walk.begin(many);
  tool.begin(&many, fitted, &walk);
  tool.add({points.first(half), {}}, 0, 1);
  tool.add({points.subspan(half), {}}, 0, 1);
  tool.fit([&](std::size_t column, const auto& use) {
    use(columns[column]);
    use(columns[column] + half * (column == 0 ? sizeof(float) : sizeof(double)));
  });
  WorkMesh<double> some = one;
  fit(samples, &one);
  fit(finite, &some);
  for (std::size_t v = 0; v < one.vertex_count(); ++v) {
    EXPECT_EQ(testing::values_of<std::int32_t>(many.point_columns[0])[v], 3);
    EXPECT_NEAR(testing::values_of<float>(many.point_columns[1])[v], one.steering[v], 1e-5);
    EXPECT_EQ(testing::values_of<double>(many.point_columns[2])[v], some.steering[v]);
  }
}

TEST(ValueFit, TakesEveryNthPoint) {
  WorkMesh<double> all = rough_box();
  const auto samples = sample(all, 4, [](const Vec3<double>& p) { return wave(p.x); });
  WorkMesh<double> some = all;
  Samples<double> third;
  for (std::size_t i = 2; i < samples.values.size(); i += 3) {
    third.positions.push_back(samples.positions[i]);
    third.values.push_back(samples.values[i]);
  }
  fit(third, &some);
  ValueFit<double> tool;
  fit_with(&tool, samples, &all, 2, 3);
  EXPECT_EQ(all.steering, some.steering);
}

// Two balls that overlap: a point where both are.
TEST(ValueFit, APointIsThatOfTheSideWhereItIsLookedFor) {
  Geometry both = testing::icosahedron_ball();
  auto& points = std::get<Vector<Vec3<double>>>(both.points);
  const auto other = static_cast<VertexId>(points.size());
  // The axis leaves the first ball at 1.62, before the middle of the second.
  const Vec3<double> middle{0.86, 0, 0};
  for (VertexId v = 0; v < other; ++v) {
    points.push_back({points[v].x + 2 * middle.x, points[v].y, points[v].z});
  }
  for (std::size_t t = 0, count = both.tets.size(); t < count; ++t) {
    Tet tet = both.tets[t];
    for (VertexId& v : tet) v += other;
    both.tets.push_back(tet);
  }
  for (const VertexId side : {VertexId{0}, other}) {
    WorkMesh<double> mesh = testing::to_work_mesh(both);
    testing::steer_by([](double, double, double) { return 1.0; }, &mesh);
    mesh.marks[0] |= kMoved;
    mesh.marks[other] |= kMoved;
    Samples<double> samples;
    samples.add(middle, [](auto) { return 4.0; });
    samples.starts.push_back(mesh.positions[side]);
    EXPECT_EQ(fit(samples, &mesh), Vector<VertexId>{side});
  }
}

// Of points beyond vertex 1, which lies outside; some are there.
double fit_outside(double far, const Vector<double>& goals, std::size_t outside) {
  WorkMesh<double> mesh = ball(1);
  mesh.marks[0] = 0;
  mesh.marks[1] |= kMoved;
  const Vec3<double> vertex = mesh.positions[1];
  Samples<double> samples;
  samples.starts.assign(goals.size(), mesh.positions[0]);
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const double x = i < outside ? far : 1;
    samples.add({x * vertex.x, x * vertex.y, x * vertex.z}, [&](auto) { return goals[i]; });
  }
  fit(samples, &mesh);
  return mesh.steering[1];
}

TEST(ValueFit, APointNotFarOutsideCountsInTheMean) {
  EXPECT_NEAR(fit_outside(1.1, {4}, 1), (4 + 0.1) / 1.1, 0.01);  // it is 1 in the middle
  EXPECT_EQ(fit_outside(1.3, {4}, 1), 1);
  // Nine say 1, so that it is 2 in the mean; what is off by more is outside.
  const double value = fit_outside(1.1, {11, 1, 1, 1, 1, 1, 1, 1, 1, 1}, 1);
  EXPECT_GT(value, 1.5);
  EXPECT_LT(value, 2);
}

TEST(ValueFit, WhatIsLinearStaysSoWherePointsLieOutside) {
  const auto linear = [](double x, double y, double z) { return 3 + x - 2 * y + z / 2; };
  WorkMesh<double> mesh = ball(1);
  testing::steer_by(linear, &mesh);
  for (std::uint8_t& mark : mesh.marks) mark |= kMoved;
  const Vector<double> before = mesh.steering;
  Samples<double> samples;
  for (VertexId v = 1; v < mesh.vertex_count(); ++v) {
    const Vec3<double> p = mesh.positions[v];
    samples.starts.push_back(mesh.positions[0]);
    samples.add({1.1 * p.x, 1.05 * p.y, 1.1 * p.z},
                [&](const Vec3<double>& at) { return linear(at.x, at.y, at.z); });
  }
  fit(samples, &mesh);
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_NEAR(mesh.steering[v], before[v], 1e-12);
}

TEST(ValueFit, ForgetsTheMeshBefore) {
  WorkMesh<double> mesh = rough_box(), same = mesh;
  const auto samples = sample(mesh, 3, [](const Vec3<double>& p) { return wave(p.x); });
  fit(samples, &mesh);
  ValueFit<double> tool;
  WorkMesh<double> other = ball(1);
  fit_with(&tool, samples, &other);
  fit_with(&tool, samples, &same);
  EXPECT_EQ(same.steering, mesh.steering);
}

TEST(ValueFit, SinglePrecisionToo) {
  WorkMesh<float> mesh = testing::to_float_work_mesh(testing::icosahedron_ball());
  testing::steer_by([](double, double, double) { return 1.0; }, &mesh);
  mesh.marks[0] |= kMoved;
  Samples<float> samples;
  samples.add(mesh.positions[0], [](auto) { return 4.0; });
  ValueFit<float> tool;
  fit_with(&tool, samples, &mesh);
  EXPECT_EQ(mesh.steering[0], 4);
}

}  // namespace
}  // namespace tetfusion
