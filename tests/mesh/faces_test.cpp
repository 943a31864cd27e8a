#include "mesh/faces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "mesh/predicates.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

struct Face {
  std::array<VertexId, 3> vertices;
  std::vector<TetId> cells;
  bool operator==(const Face&) const = default;
};

std::vector<Face> faces_of(const Geometry& mesh, VertexId v) {
  VertexTets vertex_tets;
  build_vertex_tets(point_count(mesh.points), mesh.tets, &vertex_tets);
  std::vector<Face> faces;
  FaceMatcher().for_each_face(v, mesh.tets, vertex_tets, [&](std::span<const FaceSide> sides) {
    Face face{{v, sides[0].middle(), sides[0].largest()}, {}};
    for (const FaceSide& side : sides) face.cells.push_back(side.tet());
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
  EXPECT_EQ(faces_of(mesh, 0), (std::vector<Face>{{{0, 1, 2}, {0, 1}},
                                                  {{0, 1, 3}, {0}},
                                                  {{0, 1, 4}, {1}},
                                                  {{0, 2, 3}, {0}},
                                                  {{0, 2, 4}, {1}}}));
  EXPECT_EQ(faces_of(mesh, 1), (std::vector<Face>{{{1, 2, 3}, {0}}, {{1, 2, 4}, {1}}}));
  EXPECT_TRUE(faces_of(mesh, 2).empty());
}

TEST(Faces, TwoSoundCellsSeeAFaceFromBothSides) {
  const Geometry mesh = testing::kuhn_box(3, 3, 3);
  VertexTets vertex_tets;
  build_vertex_tets(point_count(mesh.points), mesh.tets, &vertex_tets);
  FaceMatcher matcher;
  std::size_t inner = 0, outer = 0;
  for (VertexId v = 0; v < point_count(mesh.points); ++v) {
    matcher.for_each_face(v, mesh.tets, vertex_tets, [&](std::span<const FaceSide> sides) {
      for (const FaceSide& side : sides) {
        const Tet& t = mesh.tets[side.tet()];
        EXPECT_NE(t[side.corner()], v);
        EXPECT_NE(t[side.corner()], side.middle());
        EXPECT_NE(t[side.corner()], side.largest());
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
  EXPECT_TRUE(faces_of(mesh, 0).empty());
  EXPECT_TRUE(faces_of(mesh, 1).empty());
}

}  // namespace
}  // namespace tetfusion
