#include "kernel/fit/vertex_moves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "kernel/fit/value_fit.h"
#include "mesh/quality.h"
#include "support/meshes.h"
#include "support/point_deviation.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using Field = std::function<double(const Vec3<double>&)>;

// Scattered everywhere in a mesh, and where they were then.
struct Scattered {
  Vector<Vec3<double>> positions;
  Vector<double> values;
  Vector<TetId> tets;
};

Scattered scatter_in(const WorkMesh<double>& mesh, std::size_t per_tet, const Field& field) {
  Scattered out;
  for (std::size_t i = 0; i < per_tet * mesh.tets.size(); ++i) {
    const auto t = static_cast<TetId>(i / per_tet);
    std::array<double, 4> w{};
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += w[k] = 0.05 + testing::uniform(23, 4 * i + k);
    Vec3<double> p{};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3<double>& q = mesh.positions[mesh.tets[t][k]];
      p = {p.x + w[k] / sum * q.x, p.y + w[k] / sum * q.y, p.z + w[k] / sum * q.z};
    }
    out.positions.push_back(p);
    out.values.push_back(field(p));
    out.tets.push_back(t);
  }
  return out;
}

// All vertices inside are new.
WorkMesh<double> new_box(const Field& field, std::uint32_t n = 6) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(n, 0.15, 8));
  testing::steer_by([&](double x, double y, double z) { return field({x, y, z}); }, &mesh);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.marks[v] == 0) mesh.marks[v] |= kMoved;
  }
  mesh.point_columns = {testing::make_column(1, mesh.steering)};
  return mesh;
}

class VertexMovesTest : public ::testing::Test {
 protected:
  // As a run does it, with the values of the mesh's only column.
  void fit(const Scattered& points, const MoveLimits& limits, WorkMesh<double>* mesh) {
    TetWalk<double> walk;
    walk.begin(*mesh);
    const std::uint32_t column = 0;
    tool_.begin(mesh, {&column, 1}, &walk);
    const PointsToFit<double> to_fit{points.positions, {}};
    tool_.add(to_fit, 0, 1);
    const auto read = [&](std::size_t, const auto& use) {
      use(reinterpret_cast<const std::byte*>(points.values.data()));
    };
    tool_.move(limits, read, [&](const auto& take) { take(to_fit); });
    tool_.fit(read);
  }

  static MoveLimits limits(double range = 1, double floor = 0.22) {
    MoveLimits limits;
    limits.fields.resize(1);
    limits.fields[0].range = range;
    limits.fields[0].column = 0;
    limits.floor = floor;
    return limits;
  }

  // The mean square of the errors, wherever the points are now.
  static double error(const Scattered& points, WorkMesh<double>* mesh) {
    const auto values = testing::values_of<double>(mesh->point_columns[0]);
    TetWalk<double> walk;
    walk.begin(*mesh);
    double sum = 0;
    for (std::size_t i = 0; i < points.values.size(); ++i) {
      EXPECT_TRUE(walk.find(points.positions[i]));
      const auto& place = walk.place();
      const Tet& tet = mesh->tets[place.tet];
      double value = values[tet[0]];
      for (std::size_t k = 0; k < 3; ++k) {
        value += place.weights[k] * (values[tet[k + 1]] - values[tet[0]]);
      }
      sum += (value - points.values[i]) * (value - points.values[i]);
    }
    return sum / static_cast<double>(points.values.size());
  }

  static bool stays(const WorkMesh<double>& a, const WorkMesh<double>& b, VertexId v) {
    const Vec3<double>&p = a.positions[v], &q = b.positions[v];
    return p.x == q.x && p.y == q.y && p.z == q.z;
  }

  ValueFit<double> tool_;
};

double kinked(const Vec3<double>& p) { return std::abs(p.x - 2.7); }
double bumpy(const Vec3<double>& p) {
  return std::exp(-0.15 * ((p.x - 3) * (p.x - 3) + (p.y - 2) * (p.y - 2) + p.z * p.z / 4));
}

TEST_F(VertexMovesTest, AVertexGoesToWhereAFieldBends) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::icosahedron_ball());
  const Field bent = [](const Vec3<double>& p) { return std::abs(p.x - 0.08); };
  testing::steer_by([&](double x, double y, double z) { return bent({x, y, z}); }, &mesh);
  mesh.marks[0] |= kMoved;
  mesh.point_columns = {testing::make_column(1, mesh.steering)};
  const Scattered points = scatter_in(mesh, 40, bent);
  ASSERT_EQ(mesh.positions[0].x, 0);
  fit(points, limits(), &mesh);
  EXPECT_GT(mesh.positions[0].x, 0.03);
  EXPECT_LT(mesh.positions[0].x, 0.12);
  EXPECT_LT(std::hypot(mesh.positions[0].y, mesh.positions[0].z), 0.1);
}

TEST_F(VertexMovesTest, ErrorsAreSmallerThanWithoutThem) {
  for (const Field& field : {Field(kinked), Field(bumpy)}) {
    WorkMesh<double> still = new_box(field), moved = still;
    const Scattered points = scatter_in(still, 6, field);
    fit(points, {}, &still);
    fit(points, limits(), &moved);
    EXPECT_LT(error(points, &moved), 0.95 * error(points, &still));
  }
}

TEST_F(VertexMovesTest, ALinearFieldMovesNothing) {
  const Field linear = [](const Vec3<double>& p) { return 1e5 + 2 * p.x - 3 * p.y + 0.5 * p.z; };
  WorkMesh<double> mesh = new_box(linear);
  const WorkMesh<double> before = mesh;
  fit(scatter_in(mesh, 4, linear), limits(10), &mesh);
  const auto values = testing::values_of<double>(mesh.point_columns[0]);
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(values[v], linear(mesh.positions[v]), 1e-9);
  }
}

// New ones inside of the mesh, which no other chunk has, and nothing holds.
TEST_F(VertexMovesTest, OnlyNewVerticesInsideMove) {
  WorkMesh<double> mesh = new_box(bumpy);
  std::size_t next = 0;
  for (std::uint8_t& marks : mesh.marks) {
    if (marks != kMoved) continue;
    ++next;
    if (next % 4 == 1) marks |= kLocked;
    if (next % 4 == 2) marks |= kOnInterface;
    if (next % 4 == 3) marks |= kOnBoundary;
  }
  const WorkMesh<double> before = mesh;
  fit(scatter_in(mesh, 6, bumpy), limits(), &mesh);
  std::size_t moved = 0;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.marks[v] != kMoved) {
      EXPECT_TRUE(stays(before, mesh, v)) << v;
    } else if (!stays(before, mesh, v)) {
      ++moved;
    }
  }
  EXPECT_GT(moved, 2u);
}

TEST_F(VertexMovesTest, NothingBetweenRegionsMoves) {
  WorkMesh<double> mesh = new_box(bumpy);
  Vector<std::int32_t> label(mesh.tets.size());
  for (std::size_t t = 0; t < label.size(); ++t) {
    double x = 0;
    for (const VertexId v : mesh.tets[t]) x += mesh.positions[v].x / 4;
    label[t] = x > 3 ? 7 : 5;
  }
  mesh.cell_columns = {testing::make_column(1, label)};
  Vector<std::uint8_t> sides(mesh.vertex_count(), 0);
  for (std::size_t t = 0; t < label.size(); ++t) {
    for (const VertexId v : mesh.tets[t]) sides[v] |= label[t] == 7 ? 1 : 2;
  }
  const WorkMesh<double> before = mesh;
  MoveLimits all = limits();
  all.labels = {0};
  fit(scatter_in(mesh, 6, bumpy), all, &mesh);
  std::size_t moved = 0;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    if (sides[v] == 3) {
      EXPECT_TRUE(stays(before, mesh, v)) << v;
    } else if (!stays(before, mesh, v)) {
      ++moved;
    }
  }
  EXPECT_GT(moved, 5u);
}

// On meshes that are bad already, too.
TEST_F(VertexMovesTest, NoShapeIsWorseThanTheFloorUnlessItWas) {
  for (const double floor : {0.0, 0.22, 0.6}) {
    WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(6, 0.3, 5));
    testing::steer_by([&](double x, double y, double z) { return bumpy({x, y, z}); }, &mesh);
    for (std::uint8_t& marks : mesh.marks) marks |= marks == 0 ? kMoved : 0;
    mesh.point_columns = {testing::make_column(1, mesh.steering)};
    const WorkMesh<double> before = mesh;
    const Scattered points = scatter_in(mesh, 6, bumpy);
    for (int i = 0; i < 4; ++i) fit(points, limits(1, floor), &mesh);
    EXPECT_TRUE(testing::all_positive(mesh));
    std::size_t moved = 0;
    for (VertexId v = 0; v < mesh.vertex_count(); ++v) moved += stays(before, mesh, v) ? 0 : 1;
    EXPECT_GT(moved, floor < 0.5 ? 10u : 0u);
    const auto ratio = [](const WorkMesh<double>& of, const Tet& t) {
      const auto& p = of.positions;
      return measure_shape(p[t[0]], p[t[1]], p[t[2]], p[t[3]]).mean_ratio;
    };
    for (const Tet& t : mesh.tets) {
      EXPECT_GE(ratio(mesh, t), std::min(floor, ratio(before, t)) - 1e-12);
    }
  }
}

TEST_F(VertexMovesTest, ScaledByAPowerOfTwoTheMovesAreTheSame) {
  WorkMesh<double> mesh = new_box(bumpy), small = mesh;
  Scattered points = scatter_in(mesh, 6, bumpy), of_small = points;
  constexpr double kScale = 0x1p-20;
  const auto scale = [](Vec3<double>& p) { p = {p.x * kScale, p.y * kScale, p.z * kScale}; };
  for (auto& p : small.positions) scale(p);
  for (auto& p : of_small.positions) scale(p);
  fit(points, limits(), &mesh);
  fit(of_small, limits(), &small);
  for (auto& p : mesh.positions) scale(p);
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) EXPECT_TRUE(stays(mesh, small, v)) << v;
  EXPECT_EQ(mesh.point_columns[0].rows, small.point_columns[0].rows);
}

// What is no number does not spread.
TEST_F(VertexMovesTest, PointsWithoutValuesDoNotCount) {
  WorkMesh<double> mesh = new_box(bumpy);
  Scattered points = scatter_in(mesh, 6, bumpy);
  for (std::size_t i = 0; i < points.values.size(); i += 5) points.values[i] = std::nan("");
  fit(points, limits(), &mesh);
  for (const double value : testing::values_of<double>(mesh.point_columns[0])) {
    EXPECT_TRUE(std::isfinite(value));
  }
  EXPECT_TRUE(testing::all_positive(mesh));
}

}  // namespace
}  // namespace tetfusion
