// Meshes to fuse, and what must hold of them afterwards.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "kernel/fuse/fuse_round.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "support/brute_check.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion::testing {

inline constexpr double kUnit = 0x1p-4;  // for boxes of some ten cubes

inline std::uint64_t rejected(const FuseStatistics& s, Reject reason) {
  return s.pass.rejected[static_cast<std::size_t>(reason)];
}

inline double rough(double x, double y, double z) {
  return uniform(3, static_cast<std::uint64_t>(1e6 * (x + 37 * y + 1301 * z)));
}
inline double smooth(double x, double y, double z) { return std::sin(x / 3) + y * z / 40; }
inline double linear(double x, double y, double z) { return 0.3 * x - 0.2 * y + 0.1 * z + 5; }

// One field that steers.
struct Steered {
  WorkMesh<double> mesh;
  SteeringField field;
  std::span<const SteeringField> fields() const { return {&field, 1}; }
};

template <class Real>
SteeringField range_of(const WorkMesh<Real>& mesh) {
  const auto [lo, hi] = std::minmax_element(mesh.steering.begin(), mesh.steering.end());
  return {0, 1, *hi - *lo, {}};
}

template <class F>
Steered steered(Geometry geometry, F&& f, double unit = kUnit) {
  Steered s{to_work_mesh(std::move(geometry)), {}};
  steer_by(f, &s.mesh);
  s.field = range_of(s.mesh);
  begin_quadrics(s.fields(), unit, &s.mesh);
  return s;
}

inline FuseLimits limits_of(double threshold = std::numeric_limits<double>::infinity()) {
  FuseLimits limits;
  limits.threshold = threshold;
  limits.min_quality = 0.2;
  limits.unit = kUnit;
  return limits;
}

inline FuseStatistics run(const FuseLimits& limits, Steered* s) {
  return FuseRound<double>().run(limits, s->fields(), &s->mesh);
}

template <class Real>
using Corners = std::set<std::array<Real, 3>>;

template <class Real>
std::array<Real, 3> at(const WorkMesh<Real>& mesh, VertexId v) {
  const Vec3<Real>& p = mesh.positions[v];
  return {p.x, p.y, p.z};
}

template <class Real>
std::set<Corners<Real>> boundary(const WorkMesh<Real>& mesh, const BruteReport& report) {
  std::set<Corners<Real>> out;
  for (const auto& t : report.boundary) {
    out.insert({at(mesh, t[0]), at(mesh, t[1]), at(mesh, t[2])});
  }
  return out;
}

template <class Real>
void expect_same_domain(const WorkMesh<Real>& mesh, const WorkMesh<Real>& before) {
  const auto report = brute_check(to_geometry(mesh));
  const auto expected = brute_check(to_geometry(before));
  EXPECT_EQ(report.positive, mesh.tets.size());
  EXPECT_TRUE(report.conforming());
  EXPECT_EQ(report.nonmanifold_edges, expected.nonmanifold_edges);
  EXPECT_EQ(report.nonmanifold_vertices, expected.nonmanifold_vertices);
  EXPECT_EQ(report.components, expected.components);
  EXPECT_NEAR(static_cast<double>(report.volume / expected.volume), 1, 1e-13);
  EXPECT_EQ(boundary(mesh, report), boundary(before, expected));
}

// Sizes fit together, ids ascend in the order of the input's, and balls are counted.
template <class Real>
void expect_whole(const WorkMesh<Real>& mesh) {
  const std::size_t n = mesh.vertex_count();
  EXPECT_EQ(mesh.marks.size(), n);
  EXPECT_EQ(mesh.steering.size(), n * mesh.steering_width);
  EXPECT_EQ(mesh.quadrics.size(), n * mesh.quadric_width);
  EXPECT_TRUE(std::is_sorted(mesh.point_ids.begin(), mesh.point_ids.end()));
  for (const Column& c : mesh.point_columns) EXPECT_EQ(c.rows.size(), n * c.stride());
  for (const Column& c : mesh.cell_columns) EXPECT_EQ(c.rows.size(), mesh.tets.size() * c.stride());
  WorkMesh<Real> counted = mesh;
  count_incidence(&counted);
  EXPECT_EQ(mesh.incidence, counted.incidence);
}

}  // namespace tetfusion::testing
