#include "partition/spatial_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "support/cut_meshes.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::make_column;
using testing::values_of;

// Points only.
template <class Real>
WorkMesh<Real> cloud(Vector<Vec3<Real>> points) {
  WorkMesh<Real> mesh;
  mesh.resize_vertices(points.size());
  mesh.positions = std::move(points);
  mesh.marks.assign(mesh.vertex_count(), 0);
  mesh.incidence.assign(mesh.vertex_count(), 0);
  mesh.changed.assign(mesh.vertex_count(), 0);
  mesh.point_ids = count_up<VertexId>(mesh.vertex_count());
  return mesh;
}

template <class Real>
WorkMesh<Real> ordered(const WorkMesh<Real>& mesh, std::uint32_t round = 0) {
  WorkMesh<Real> out;
  order_along_curve(ShiftedCurve(testing::box_of(mesh), round), mesh, &out);
  return out;
}

Vector<Vec3<float>> grid(int side) {
  Vector<Vec3<float>> points;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        points.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
      }
    }
  }
  return points;
}

TEST(OrderAlongCurve, IsAPermutationWhoseStepsAreShort) {
  const WorkMesh<float> mesh = ordered(cloud(grid(16)));
  Vector<VertexId> sorted = mesh.point_ids;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, count_up<VertexId>(16 * 16 * 16));
  double length = 0;
  for (std::size_t i = 1; i < mesh.vertex_count(); ++i) {
    const Vec3<float>&a = mesh.positions[i - 1], &b = mesh.positions[i];
    length += std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z);
  }
  // The curve steps from cell to neighbouring cell, so the mean step is one, give or take the
  // grid's rounding.
  EXPECT_LT(length / static_cast<double>(mesh.vertex_count()), 1.2);
}

// What a worker has left of another chunk, with as many tetrahedra, is none of this one's.
TEST(OrderAlongCurve, ForgetsThePointsRemovedFromAnotherMesh) {
  WorkMesh<float> mesh = cloud(grid(2));
  mesh.resize_tets(1);
  mesh.tets[0] = {0, 1, 2, 4};
  mesh.remembered.assign(1, 0);
  WorkMesh<float> out;
  out.removed.reset(1);
  out.removed.push(0, out.removed.add(1, 0));
  order_along_curve(ShiftedCurve(testing::box_of(mesh), 0), mesh, &out);
  EXPECT_FALSE(out.removed.wanted());
  EXPECT_EQ(out.removed.size(), 0U);
}

TEST(OrderAlongCurve, TakesPointsThatAreAllTheSame) {
  const auto mesh = ordered(cloud(Vector<Vec3<float>>(5, Vec3<float>{1, 2, 3})));
  EXPECT_EQ(mesh.point_ids, count_up<VertexId>(5));
}

TEST(OrderAlongCurve, TakesTheWholeRangeOfDoubles) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  auto mesh = ordered(cloud<double>({{kHuge, 0, 0}, {-kHuge, 0, 0}, {0, 0, 0}}));
  std::sort(mesh.point_ids.begin(), mesh.point_ids.end());
  EXPECT_EQ(mesh.point_ids, count_up<VertexId>(3));
}

TEST(OrderAlongCurve, TakesPointsThatAreNoNumbers) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  constexpr double kBeyondAll = std::numeric_limits<double>::infinity();
  auto mesh =
      ordered(cloud<double>({{kNoNumber, 0, 0}, {1, 1, -kBeyondAll}, {0, 0, 0}, {1, 2, 3}}));
  std::sort(mesh.point_ids.begin(), mesh.point_ids.end());
  EXPECT_EQ(mesh.point_ids, count_up<VertexId>(4));
}

TEST(OrderAlongCurve, TakesAnEmptyMesh) {
  const WorkMesh<double> mesh = ordered(WorkMesh<double>{});
  EXPECT_EQ(mesh.vertex_count(), 0u);
  EXPECT_TRUE(mesh.tets.empty());
}

TEST(OrderAlongCurve, PutsTetrahedraByTheirSmallestVertexStably) {
  WorkMesh<float> mesh = cloud(grid(3));
  for (std::uint64_t t = 0; t < 200; ++t) {  // any four points
    Tet& tet = mesh.tets.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      tet[k] = static_cast<VertexId>(27 * testing::uniform(3, 4 * t + k));
    }
  }
  mesh.remembered.assign(200, 0);
  testing::number_tets(&mesh);
  const WorkMesh<float> out = ordered(mesh);
  Vector<VertexId> new_ids(27);
  for (VertexId v = 0; v < 27; ++v) new_ids[out.point_ids[v]] = v;
  Vector<TetId> expected = count_up<TetId>(200);
  std::ranges::stable_sort(expected, {}, [&](TetId t) {
    const Tet& tet = mesh.tets[t];
    return std::min({new_ids[tet[0]], new_ids[tet[1]], new_ids[tet[2]], new_ids[tet[3]]});
  });
  EXPECT_TRUE(std::ranges::equal(testing::tet_numbers(out), expected));
}

TEST(OrderAlongCurve, KeepsTheMeshAndAllThatItKnows) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(5, 0.1));
  mesh.steering_width = 2;
  mesh.resize_vertices(mesh.vertex_count());
  for (std::size_t i = 0; i < mesh.steering.size(); ++i) mesh.steering[i] = 7.0 * double(i);
  testing::number_tets(&mesh);
  Vector<float> triples;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const auto x = static_cast<float>(v);
    triples.insert(triples.end(), {x, -x, 2 * x});
    mesh.changed[v] = static_cast<std::uint16_t>(v % 7);
  }
  mesh.point_columns = {make_column(3, triples)};
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    mesh.remembered[t] = static_cast<std::uint16_t>(t % 5);
  }
  for (const std::uint32_t round : {0u, 1u, 17u}) {
    const WorkMesh<double> out = ordered(mesh, round);
    EXPECT_EQ(testing::contents(out), testing::contents(mesh));
    EXPECT_NE(out.point_ids, mesh.point_ids);
    const auto numbers = testing::tet_numbers(out);
    VertexId last = 0;
    for (std::size_t t = 0; t < out.tets.size(); ++t) {
      EXPECT_EQ(out.remembered[t], mesh.remembered[numbers[t]]);
      const VertexId first = *std::min_element(out.tets[t].begin(), out.tets[t].end());
      EXPECT_GE(first, last);
      last = first;
    }
    const ShiftedCurve curve(testing::box_of(mesh), round);
    EXPECT_TRUE(
        std::ranges::is_sorted(out.positions, {}, [&](const auto& p) { return curve.key(p); }));
    for (std::size_t v = 0; v < out.vertex_count(); ++v) {
      EXPECT_EQ(out.incidence[v], mesh.incidence[out.point_ids[v]]);
      EXPECT_EQ(out.changed[v], mesh.changed[out.point_ids[v]]);
    }
  }
}

}  // namespace
}  // namespace tetfusion
