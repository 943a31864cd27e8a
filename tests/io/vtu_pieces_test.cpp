// One mesh out of several pieces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"
#include "support/meshes.h"
#include "support/vtu_file_test.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using testing::coordinates;
using ::testing::ElementsAre;
using testing::kCoordinates;
using testing::plain;
using testing::tet_piece;
using testing::tets;
using testing::values;
using testing::VtuPieceText;
using testing::VtuText;

class VtuPieces : public testing::VtuFileTest {};

TEST_F(VtuPieces, SplitsHexahedraAcrossPiecesAlike) {
  // Two unit cubes side by side, whole and as two pieces whose points are numbered in another
  // order.
  std::vector<double> left;
  std::vector<double> right;
  for (const double z : {0, 1}) {
    for (const double y : {0, 1}) {
      for (const double x : {0, 1}) {
        left.insert(left.end(), {x, y, z});
        right.insert(right.end(), {2 - x, y, z});
      }
    }
  }
  const std::vector<double> voxel = {0, 1, 2, 3, 4, 5, 6, 7};
  VtuText mesh;
  mesh.pieces = {cell_piece(left, {11}, {voxel}), cell_piece(right, {11}, {voxel})};
  const Geometry g = read(mesh, {true, false});
  EXPECT_EQ(g.merged_points, 4u);
  EXPECT_EQ(point_count(g.points), 12u);
  // The square between them is cut by one diagonal: two triangles of x = 1 belong to two tetrahedra
  // each.
  std::multiset<std::set<VertexId>> faces;
  const auto& points = std::get<Vector<Vec3<double>>>(g.points);
  for (const Tet& t : g.tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::set<VertexId> face(t.begin(), t.end());
      face.erase(t[k]);
      bool between = true;
      for (const VertexId v : face) between = between && points[v].x == 1;
      if (between) faces.insert(face);
    }
  }
  EXPECT_EQ(faces.size(), 4u);
  for (const auto& face : faces) EXPECT_EQ(faces.count(face), 2u);
  EXPECT_EQ(g.tet_source.size(), g.tets.size());
  EXPECT_EQ(g.tet_source.back(), 1u);
}

TEST_F(VtuPieces, MergesPiecesByCoordinates) {
  const VtuPieceText first = tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {0, 1, 2, 3});
  // The shared points in another order, one of them with a negative zero.
  VtuPieceText second = tet_piece({1, 1, -1e-3, -0.0, 0, 0.1, 1, -0.0, 0, 0, 1, 0}, {0, 3, 2, 1});
  VtuText mesh;
  mesh.pieces = {first, VtuPieceText{}, second};
  mesh.pieces[0].point_data = {{"a", "Float32", {1, 2, 3, 4}, 1, "", "DataArray"}};
  mesh.pieces[2].point_data = {{"a", "Float32", {5, 6, 7, 8}, 1, "", "DataArray"}};
  const auto source = open(mesh);
  EXPECT_EQ(source->description().pieces, 3u);
  EXPECT_EQ(source->description().points, 8u);
  const Geometry g = source->read_geometry();
  EXPECT_EQ(coordinates<double>(g), kCoordinates);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_EQ(plain(g.point_source), (std::vector<std::uint64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(source->description().point_data.arrays[0].tuples, 8u);
  EXPECT_EQ(values<float>(source->read_array(Association::kPoint, 0)),
            (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(VtuPieces, MergesPiecesByGlobalIds) {
  // The coordinates differ by rounding; the ids agree. The attribute marks the array, or its name
  // does.
  for (const bool marked : {false, true}) {
    const std::string name = marked ? "ids" : "GlobalNodeIds";
    VtuText mesh;
    mesh.pieces = {tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {0, 1, 2, 3}),
                   tet_piece({1, 1, 0, 0, 0, 0.100001, 1, 0, 1e-6, 1e-6, 1, 0}, {0, 3, 2, 1})};
    mesh.pieces[0].point_data = {{name, "Int64", {10, 11, 12, 13}, 1, "", "DataArray"}};
    mesh.pieces[1].point_data = {{name, "Int64", {14, 13, 11, 12}, 1, "", "DataArray"}};
    if (marked) {
      for (VtuPieceText& p : mesh.pieces) p.point_attributes = " GlobalIds=\"ids\"";
    }
    const Geometry g = read(mesh);
    EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
    EXPECT_EQ(g.merged_points, 3u);
  }
}

// Each piece counts its points from one, as where results of two parts were put together.
TEST_F(VtuPieces, IdsOfPointsThatLieApartAreNotGlobal) {
  VtuText mesh;
  mesh.pieces = {tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {0, 1, 2, 3}),
                 tet_piece({1, 1, 0, 0, 0, 0.1, 1, 0, 0, 0, 1, 0}, {0, 3, 2, 1})};
  for (VtuPieceText& p : mesh.pieces) {
    p.point_data = {{"GlobalNodeIds", "Int64", {1, 2, 3, 4}, 1, "", "DataArray"}};
  }
  const Geometry g = read(mesh);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));  // by their places
  const auto source = open(mesh);
  const auto stream = open_stream(source.get());
  EXPECT_EQ(stream->points(), 5u);
  CellWindow window;
  stream->read_cells(0, 2, &window);
  EXPECT_THAT(window.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
}

// The corners of each tetrahedron as coordinates.
std::vector<std::vector<Vec3<double>>> corners(const Geometry& mesh) {
  std::vector<std::vector<Vec3<double>>> out;
  const auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
  for (const Tet& t : mesh.tets) {
    out.emplace_back();
    for (const VertexId v : t) out.back().push_back(points[v]);
  }
  return out;
}

TEST_F(VtuPieces, CutIntoPiecesIsTheSameMesh) {
  const Geometry whole = testing::five_split_cube(4, 0.1);
  const std::size_t n = whole.tets.size();
  for (std::size_t pieces = 1; pieces <= 64; pieces *= 2) {
    SCOPED_TRACE(pieces);
    VtuText mesh;
    for (std::size_t p = 0; p < pieces; ++p) {
      std::vector<double> xyz;
      std::vector<double> ids;
      std::map<VertexId, double> local;
      for (std::size_t t = n * p / pieces; t < n * (p + 1) / pieces; ++t) {
        for (const VertexId v : whole.tets[t]) {
          const auto [it, fresh] = local.try_emplace(v, static_cast<double>(local.size()));
          const Vec3<double> at = testing::point(whole, v);
          if (fresh) xyz.insert(xyz.end(), {at.x, at.y, at.z});
          ids.push_back(it->second);
        }
      }
      mesh.pieces.push_back(tet_piece(xyz, ids));
    }
    const Geometry g = read(mesh);
    ASSERT_EQ(g.tets.size(), n);
    EXPECT_EQ(point_count(g.points), point_count(whole.points));
    const auto expected = corners(whole);
    const auto found = corners(g);
    for (std::size_t t = 0; t < n; ++t) {
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(found[t][k].x, expected[t][k].x);
        EXPECT_EQ(found[t][k].y, expected[t][k].y);
        EXPECT_EQ(found[t][k].z, expected[t][k].z);
      }
    }
  }
}

TEST_F(VtuPieces, NeverMergesWithinAPiece) {
  // Points 1 and 4 of both pieces coincide: the two sides of a crack that both pieces see.
  const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0};
  VtuText mesh;
  mesh.pieces = {tet_piece(xyz, {0, 1, 2, 3, 0, 4, 2, 3})};
  EXPECT_EQ(read(mesh).merged_points, 0u);
  mesh.pieces.push_back(mesh.pieces[0]);
  const Geometry g = read(mesh);
  EXPECT_EQ(g.merged_points, 5u);
  EXPECT_THAT(tets(g),
              ElementsAre(Tet{0, 1, 2, 3}, Tet{0, 4, 2, 3}, Tet{0, 1, 2, 3}, Tet{0, 4, 2, 3}));
}

}  // namespace
}  // namespace tetfusion
