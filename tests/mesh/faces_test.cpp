#include "mesh/faces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "mesh/predicates.h"
#include "support/damaged_meshes.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct Face {
  std::array<VertexId, 3> vertices;
  std::vector<TetId> cells;
  bool operator==(const Face&) const = default;
};

FaceMatcher load(const Geometry& mesh) {
  FaceMatcher matcher;
  const auto points = static_cast<VertexId>(point_count(mesh.points));
  matcher.load(mesh.tets, {}, 0, points, points);
  return matcher;
}

std::vector<Face> faces_of(FaceMatcher* matcher, VertexId v) {
  std::vector<Face> faces;
  matcher->for_each_face(v, [&](std::span<const FaceSide> sides) {
    Face face{{v, sides[0].middle(), sides[0].largest()}, {}};
    for (const FaceSide& side : sides) face.cells.push_back(side.tet);
    faces.push_back(face);
  });
  return faces;
}

TEST(Faces, FaceCornersPointOutwards) {
  const Geometry mesh = testing::single_tet();
  const auto& p = std::get<Vector<Vec3<double>>>(mesh.points);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto& f = kFaceCorners[corner];
    EXPECT_LT(determinant(p[f[0]], p[f[1]], p[f[2]], p[corner]).value, 0);
  }
}

TEST(Faces, BelongToTheirSmallestVertex) {
  const Geometry mesh = testing::two_tets_sharing_face();
  FaceMatcher matcher = load(mesh);
  EXPECT_EQ(faces_of(&matcher, 0), (std::vector<Face>{{{0, 1, 2}, {0, 1}},
                                                      {{0, 1, 3}, {0}},
                                                      {{0, 1, 4}, {1}},
                                                      {{0, 2, 3}, {0}},
                                                      {{0, 2, 4}, {1}}}));
  EXPECT_EQ(faces_of(&matcher, 1), (std::vector<Face>{{{1, 2, 3}, {0}}, {{1, 2, 4}, {1}}}));
  EXPECT_THAT(faces_of(&matcher, 2), IsEmpty());
  EXPECT_EQ(matcher.cell_count(0), 2u);
  EXPECT_EQ(matcher.cell_count(4), 1u);
  EXPECT_THAT(matcher.larger_neighbours(0), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(matcher.larger_neighbours(2), ElementsAre(3, 4));
}

TEST(Faces, MatchedTheFastWayOfTwoCells) {
  const Geometry mesh = testing::two_tets_sharing_face();
  FaceMatcher matcher = load(mesh);
  ASSERT_TRUE(matcher.match(0));
  std::set<std::array<VertexId, 3>> singles;
  matcher.for_each_single([&](VertexId m, VertexId l) { singles.insert({0, m, l}); });
  // As seen from outside.
  EXPECT_EQ(singles,
            (std::set<std::array<VertexId, 3>>{{0, 1, 3}, {0, 3, 2}, {0, 4, 1}, {0, 2, 4}}));
  std::vector<std::set<VertexId>> pairs;
  matcher.for_each_pair(~std::uint64_t{0}, [&](VertexId m, VertexId l) {
    pairs.push_back({m, l});
  });
  EXPECT_THAT(pairs, ElementsAre(std::set<VertexId>{1, 2}));
  pairs.clear();
  const std::uint64_t all_but_1 = ~(std::uint64_t{1} << matcher.number_of(1));
  matcher.for_each_pair(all_but_1, [&](VertexId m, VertexId l) { pairs.push_back({m, l}); });
  EXPECT_THAT(pairs, IsEmpty());

  std::set<std::pair<TetId, VertexId>> cells;
  matcher.for_each_cell_of_face(0, 2, 1, [&](TetId t, VertexId apex) { cells.insert({t, apex}); });
  EXPECT_EQ(cells, (std::set<std::pair<TetId, VertexId>>{{0, 3}, {1, 4}}));
}

TEST(Faces, TwoSoundCellsSeeAFaceFromBothSides) {
  const Geometry mesh = testing::kuhn_box(3, 3, 3);
  FaceMatcher matcher = load(mesh);
  std::size_t inner = 0, outer = 0;
  for (VertexId v = 0; v < point_count(mesh.points); ++v) {
    matcher.for_each_face(v, [&](std::span<const FaceSide> sides) {
      for (const FaceSide& side : sides) {
        const Tet& t = mesh.tets[side.tet];
        EXPECT_EQ(std::count(t.begin(), t.end(), side.apex), 1);
        EXPECT_NE(side.apex, v);
        EXPECT_NE(side.apex, side.middle());
        EXPECT_NE(side.apex, side.largest());
      }
      ASSERT_LE(sides.size(), 2u);
      if (sides.size() == 2) {
        EXPECT_NE(sides[0].odd, sides[1].odd);
      }
      ++(sides.size() == 2 ? inner : outer);
    });
  }
  EXPECT_EQ(outer, 6u * 3 * 3 * 2);
  EXPECT_EQ(2 * inner + outer, 4 * mesh.tets.size());
}

TEST(Faces, ACellThatNamesAVertexTwiceHasNone) {
  Geometry mesh = testing::single_tet();
  mesh.tets[0] = {0, 1, 2, 1};
  FaceMatcher matcher = load(mesh);
  for (VertexId v = 0; v < 4; ++v) {
    EXPECT_THAT(faces_of(&matcher, v), IsEmpty());
    EXPECT_EQ(matcher.cell_count(v), 0u);
    EXPECT_TRUE(matcher.match(v));
    EXPECT_THAT(matcher.neighbours(), IsEmpty());
  }
}

// A fan of cells round the edge from 0 to 1.
Geometry fan(VertexId cells) {
  Geometry mesh = testing::single_tet();
  mesh.tets.clear();
  for (VertexId i = 0; i < cells; ++i) mesh.tets.push_back({0, 1, i + 2, i + 3});
  std::get<Vector<Vec3<double>>>(mesh.points).resize(cells + 3, {0, 0, 0});
  return mesh;
}

TEST(Faces, SixtyFourNeighboursCanBeMatchedAndMoreCannot) {
  for (const VertexId cells : {10u, 58u, 59u, 60u, 61u, 62u, 63u, 64u, 200u}) {
    FaceMatcher matcher = load(fan(cells));
    EXPECT_EQ(matcher.larger_neighbours(0).size(), cells + 2);
    if (matcher.match(0)) {
      EXPECT_LE(cells + 2, 64u);
      EXPECT_EQ(matcher.neighbours().size(), cells + 2);
      std::size_t singles = 0, pairs = 0;
      matcher.for_each_single([&](VertexId, VertexId) { ++singles; });
      matcher.for_each_pair(~std::uint64_t{0}, [&](VertexId, VertexId) { ++pairs; });
      EXPECT_EQ(pairs, cells - 1);
      EXPECT_EQ(singles, cells + 2);
    } else {
      EXPECT_GT(cells + 2, 60u);
    }
    // What was left half done leaves no trace.
    EXPECT_EQ(matcher.match(2), true);
    EXPECT_EQ(matcher.neighbours().size(), 1u);
  }
}

// The fast way agrees with the slow one, for ranges and lists of cells too.
TEST(FacesProperty, BothWaysAgree) {
  std::size_t fast = 0, slow = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Geometry mesh = testing::damaged_mesh(seed);
    testing::shuffle(&mesh, seed);
    const auto points = static_cast<VertexId>(point_count(mesh.points));
    const auto begin = static_cast<VertexId>(testing::uniform(seed, 1) * points);
    const VertexId end =
        begin + static_cast<VertexId>(testing::uniform(seed, 2) * (points - begin));
    Vector<TetId> cells;
    for (TetId t = 0; t < mesh.tets.size(); ++t) {
      const bool used = std::any_of(mesh.tets[t].begin(), mesh.tets[t].end(),
                                    [&](VertexId v) { return v >= begin && v < end; });
      if (used || t % 5 == 0) cells.push_back(t);
    }
    FaceMatcher whole = load(mesh), part;
    part.load(mesh.tets, cells, begin, end, points);
    for (VertexId v = begin; v < end; ++v) {
      const auto faces = faces_of(&whole, v);
      ASSERT_EQ(faces_of(&part, v), faces);
      ASSERT_EQ(part.cell_count(v), whole.cell_count(v));
      const auto larger = part.larger_neighbours(v);
      const std::set<VertexId> neighbours(larger.begin(), larger.end());
      if (!part.match(v)) {
        ++slow;
        continue;
      }
      ++fast;
      ASSERT_EQ(std::set<VertexId>(part.neighbours().begin(), part.neighbours().end()), neighbours);
      std::set<std::array<VertexId, 3>> singles, pairs;
      part.for_each_single([&](VertexId m, VertexId l) {
        singles.insert({v, std::min(m, l), std::max(m, l)});
      });
      part.for_each_pair(~std::uint64_t{0}, [&](VertexId m, VertexId l) {
        pairs.insert({v, std::min(m, l), std::max(m, l)});
      });
      ASSERT_EQ(singles.size() + pairs.size(), faces.size());
      for (const Face& face : faces) {
        ASSERT_LE(face.cells.size(), 2u);
        ASSERT_EQ((face.cells.size() == 1 ? singles : pairs).count(face.vertices), 1u);
        std::set<TetId> found;
        part.for_each_cell_of_face(v, face.vertices[1], face.vertices[2],
                                   [&](TetId t, VertexId) { found.insert(t); });
        ASSERT_EQ(found, std::set<TetId>(face.cells.begin(), face.cells.end()));
      }
    }
  }
  EXPECT_GT(fast, 1000u);
  EXPECT_GT(slow, 50u);
}

}  // namespace
}  // namespace tetfusion
