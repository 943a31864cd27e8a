#include "mesh/split_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "mesh/predicates.h"

namespace tetfusion {
namespace {

using Ids = std::vector<VertexId>;
using Position = Vec3<double>;
using TriangleKey = std::array<VertexId, 3>;

struct Shape {
  std::uint8_t type;
  std::vector<Position> corners;        // positively wound, convex, faces flat
  std::vector<std::vector<int>> faces;  // outwards
  double volume;
};

Shape hexahedron() {
  return {kVtkHexahedron,
          {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}, {1, 0, 1}, {3, 0, 1}, {3, 3, 1}, {1, 3, 1}},
          {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}},
          6.0};
}

Shape voxel() {
  return {kVtkVoxel,
          {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3, 0}, {0, 0, 1}, {2, 0, 1}, {0, 3, 1}, {2, 3, 1}},
          {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}},
          6.0};
}

Shape wedge() {
  return {kVtkWedge,
          {{0, 0, 0}, {0, 2, 0}, {2, 0, 0}, {0, 0, 3}, {0, 2, 3}, {2, 0, 3}},
          {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}},
          6.0};
}

Shape pyramid() {
  return {kVtkPyramid,
          {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 3}},
          {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
          4.0};
}

TriangleKey key(VertexId a, VertexId b, VertexId c) {
  TriangleKey k = {a, b, c};
  std::sort(k.begin(), k.end());
  return k;
}

std::vector<Tet> split(std::uint8_t type, const Ids& ids) {
  std::array<Tet, 6> out;
  const int count = split_cell(type, ids, out);
  return {out.begin(), out.begin() + count};
}

// How many of the tetrahedra have each triangle.
std::map<TriangleKey, int> count_faces(const std::vector<Tet>& tets) {
  std::map<TriangleKey, int> faces;
  for (const Tet& t : tets) {
    ++faces[key(t[0], t[1], t[2])];
    ++faces[key(t[0], t[1], t[3])];
    ++faces[key(t[0], t[2], t[3])];
    ++faces[key(t[1], t[2], t[3])];
  }
  return faces;
}

std::set<TriangleKey> surface(const std::vector<Tet>& tets) {
  std::set<TriangleKey> once;
  for (const auto& [triangle, count] : count_faces(tets)) {
    EXPECT_LE(count, 2);
    if (count == 1) once.insert(triangle);
  }
  return once;
}

// The cell's faces, each quadrilateral cut at its smallest id.
std::set<TriangleKey> expected_surface(const Shape& shape, const Ids& ids) {
  std::set<TriangleKey> triangles;
  for (const auto& face : shape.faces) {
    const int n = static_cast<int>(face.size());
    int s = 0;
    for (int i = 1; i < n; ++i) {
      if (ids[face[i]] < ids[face[s]]) s = i;
    }
    for (int i = 1; i + 1 < n; ++i) {
      triangles.insert(key(ids[face[s]], ids[face[(s + i) % n]], ids[face[(s + i + 1) % n]]));
    }
  }
  return triangles;
}

double six_volumes(const Tet& t, const std::map<VertexId, Position>& at) {
  return determinant(at.at(t[0]), at.at(t[1]), at.at(t[2]), at.at(t[3])).value;
}

class SplitCell : public ::testing::TestWithParam<Shape> {};

TEST_P(SplitCell, FillsTheCellForEveryNumbering) {
  const Shape& shape = GetParam();
  Ids ids(shape.corners.size());
  std::iota(ids.begin(), ids.end(), VertexId{10});
  std::set<std::size_t> counts;
  do {
    std::map<VertexId, Position> at;
    for (std::size_t i = 0; i < ids.size(); ++i) at[ids[i]] = shape.corners[i];
    const std::vector<Tet> tets = split(shape.type, ids);
    double volume = 0;
    for (const Tet& t : tets) {
      ASSERT_GT(six_volumes(t, at), 0.5) << ::testing::PrintToString(ids);
      volume += six_volumes(t, at) / 6;
    }
    ASSERT_NEAR(volume, shape.volume, 1e-12) << ::testing::PrintToString(ids);
    ASSERT_EQ(surface(tets), expected_surface(shape, ids)) << ::testing::PrintToString(ids);
    counts.insert(tets.size());
  } while (std::next_permutation(ids.begin(), ids.end()));

  if (shape.type == kVtkWedge) {
    EXPECT_EQ(counts, (std::set<std::size_t>{3}));
  } else if (shape.type == kVtkPyramid) {
    EXPECT_EQ(counts, (std::set<std::size_t>{2}));
  } else {
    EXPECT_EQ(counts, (std::set<std::size_t>{5, 6}));
  }
}

INSTANTIATE_TEST_SUITE_P(AllKinds, SplitCell,
                         ::testing::Values(hexahedron(), voxel(), wedge(), pyramid()),
                         [](const auto& instance) {
                           return std::string(vtk_cell_name(instance.param.type));
                         });

TEST(SplitCells, SmallestVertexOfAllGivesFiveIfTheOthersAgree) {
  // The three faces away from vertex 0 are cut at 2, 5 and 7: no diagonal ends at 6.
  EXPECT_EQ(split(kVtkHexahedron, {0, 4, 1, 5, 6, 2, 7, 3}).size(), 5u);
  // The far corner holds the second smallest id: all three diagonals end there.
  EXPECT_EQ(split(kVtkHexahedron, {0, 2, 3, 4, 5, 6, 1, 7}).size(), 6u);
}

TEST(SplitCells, MirroredCellsGiveNegativeTetrahedra) {
  const Shape shape = wedge();
  const std::vector<int> mirror = {0, 2, 1, 3, 5, 4};
  std::map<VertexId, Position> at;
  Ids ids;
  for (VertexId i = 0; i < 6; ++i) {
    at[i] = shape.corners[i];
    ids.push_back(static_cast<VertexId>(mirror[i]));
  }
  const auto tets = split(kVtkWedge, ids);
  ASSERT_EQ(tets.size(), 3u);
  for (const Tet& t : tets) EXPECT_LT(six_volumes(t, at), 0);
}

TEST(SplitCells, NeighboursOfAllKindsConform) {
  // Two hexahedra side by side, a pyramid on the first one, a wedge on the second one's end.
  //
  //      12
  //     .  .
  //   4------5------9
  //   |      |      |  .13
  //   0------1------8 .
  //
  const std::vector<std::pair<std::uint8_t, Ids>> cells = {
      {kVtkHexahedron, {0, 1, 2, 3, 4, 5, 6, 7}},
      {kVtkVoxel, {1, 8, 2, 10, 5, 9, 6, 11}},
      {kVtkPyramid, {4, 5, 6, 7, 12}},
      {kVtkWedge, {8, 13, 10, 9, 14, 11}}};
  constexpr int kPoints = 15;
  std::mt19937 random(1);
  Ids number(kPoints);
  std::iota(number.begin(), number.end(), VertexId{0});
  for (int trial = 0; trial < 5000; ++trial) {
    std::shuffle(number.begin(), number.end(), random);
    std::vector<Tet> tets;
    for (const auto& [type, corners] : cells) {
      Ids ids;
      for (const VertexId c : corners) ids.push_back(number[c]);
      const auto part = split(type, ids);
      tets.insert(tets.end(), part.begin(), part.end());
    }
    // 5 + 4 quadrilaterals of the boxes less one under the pyramid and one under the wedge, 4
    // triangles, and the wedge's 2 triangles and 2 quadrilaterals: 24 triangles, if both sides of
    // every inner face agree.
    const auto outside = surface(tets);
    ASSERT_EQ(outside.size(), 2u * (4 + 4) + 4 + 2 + 2 * 2) << "trial " << trial;
  }
}

std::vector<TriangleKey> degenerate_surface(const Shape& shape, const Ids& ids) {
  std::map<TriangleKey, int> count;
  for (const auto& face : shape.faces) {
    Ids corners;
    for (const int c : face) {
      if (std::find(corners.begin(), corners.end(), ids[c]) == corners.end())
        corners.push_back(ids[c]);
    }
    const std::size_t n = corners.size();
    const std::size_t s = std::min_element(corners.begin(), corners.end()) - corners.begin();
    for (std::size_t i = 1; i + 1 < n; ++i) {
      ++count[key(corners[s], corners[(s + i) % n], corners[(s + i + 1) % n])];
    }
  }
  std::vector<TriangleKey> odd;
  for (const auto& [triangle, times] : count) {
    if (times == 1) odd.push_back(triangle);
  }
  return odd;
}

TEST(SplitCells, CollapsedHexahedraAreWhatTheyLookLike) {
  struct Case {
    std::string name;
    std::array<int, 8> corners;
    std::size_t tets;
  };
  const std::vector<Case> cases = {{"wedge", {0, 1, 2, 2, 3, 4, 5, 5}, 3},
                                   {"pyramid", {0, 1, 2, 3, 4, 4, 4, 4}, 2},
                                   {"tetrahedron", {0, 1, 2, 2, 3, 3, 3, 3}, 1},
                                   {"line", {0, 0, 0, 0, 1, 1, 1, 1}, 0},
                                   {"quadrilateral", {0, 1, 2, 3, 0, 1, 2, 3}, 0}};
  for (const Case& c : cases) {
    Ids number = {0, 1, 2, 3, 4, 5};
    do {
      Ids ids;
      for (const int corner : c.corners) ids.push_back(number[static_cast<std::size_t>(corner)]);
      const auto tets = split(kVtkHexahedron, ids);
      ASSERT_EQ(tets.size(), c.tets) << c.name << ::testing::PrintToString(ids);
      const auto outside = surface(tets);
      ASSERT_THAT(degenerate_surface(hexahedron(), ids), ::testing::ElementsAreArray(outside))
          << c.name;
    } while (std::next_permutation(number.begin(), number.end()));
  }
}

TEST(SplitCells, AnyCollapsedEdgeKeepsSurfaceAndDistinctVertices) {
  const Shape shape = hexahedron();
  std::mt19937 random(2);
  for (const auto& face : shape.faces) {
    for (std::size_t i = 0; i < 4; ++i) {
      Ids number = {0, 1, 2, 3, 4, 5, 6, 7};
      for (int trial = 0; trial < 500; ++trial) {
        std::shuffle(number.begin(), number.end(), random);
        Ids ids = number;
        ids[face[i]] = ids[face[(i + 1) % 4]];
        const auto tets = split(kVtkHexahedron, ids);
        std::set<std::set<VertexId>> distinct;
        for (const Tet& t : tets) {
          const std::set<VertexId> corners(t.begin(), t.end());
          ASSERT_EQ(corners.size(), 4u);
          ASSERT_TRUE(distinct.insert(corners).second) << ::testing::PrintToString(ids);
        }
        ASSERT_THAT(degenerate_surface(shape, ids), ::testing::ElementsAreArray(surface(tets)));
      }
    }
  }
}

TEST(SplitCells, TetrahedraAreCopied) {
  EXPECT_THAT(split(kVtkTetra, {7, 5, 9, 2}), ::testing::ElementsAre(Tet{7, 5, 9, 2}));
  EXPECT_TRUE(split(kVtkTetra, {7, 5, 7, 2}).empty());
}

TEST(SplitCells, OtherTypesGiveNothing) {
  EXPECT_TRUE(split(kVtkTriangle, {0, 1, 2}).empty());
  EXPECT_TRUE(split(255, {}).empty());
  EXPECT_FALSE(is_splittable(kVtkTriangle));
  EXPECT_TRUE(is_splittable(kVtkTetra));
  EXPECT_TRUE(is_splittable(kVtkPyramid));
  EXPECT_FALSE(is_splittable(15));
}

TEST(SplitCells, KnowsVtksNamesAndSizes) {
  EXPECT_EQ(vtk_cell_name(12), "hexahedron");
  EXPECT_EQ(vtk_cell_name(24), "quadratic tetrahedron");
  EXPECT_EQ(vtk_cell_name(42), "polyhedron");
  EXPECT_EQ(vtk_cell_name(71), "Lagrange tetrahedron");
  EXPECT_EQ(vtk_cell_name(81), "Bezier pyramid");
  EXPECT_EQ(vtk_cell_name(17), "unknown cell");
  EXPECT_EQ(vtk_cell_name(255), "unknown cell");
  EXPECT_EQ(vtk_cell_size(10), 4);
  EXPECT_EQ(vtk_cell_size(24), 10);
  EXPECT_EQ(vtk_cell_size(37), 19);
  EXPECT_EQ(vtk_cell_size(42), 0);
  EXPECT_EQ(vtk_cell_size(200), 0);
}

}  // namespace
}  // namespace tetfusion
