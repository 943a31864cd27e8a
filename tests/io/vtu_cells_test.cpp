// Which cells of a .vtu file are read, and as what.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "io/source/mesh_source.h"
#include "mesh/predicates.h"
#include "support/vtu_file_test.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using testing::coordinates;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kCoordinates;
using testing::kIds;
using testing::plain;
using ::testing::StartsWith;
using testing::tet_piece;
using testing::tets;
using testing::thrown_by;
using testing::values;
using testing::VtuPieceText;
using testing::VtuText;

class VtuCellKinds : public testing::VtuFileTest {};

TEST_F(VtuCellKinds, DropsUnusedPoints) {
  VtuText mesh;
  mesh.pieces = {tet_piece({9, 9, 9, 0, 0, 0, 1, 0, 0, 8, 8, 8, 0, 1, 0, 0, 0, 1}, {1, 2, 4, 5})};
  const Geometry g = read(mesh);
  EXPECT_EQ(g.unused_points, 2u);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_EQ(plain(g.point_source), (std::vector<std::uint64_t>{1, 2, 4, 5}));
  EXPECT_EQ(coordinates<double>(g), (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
}

// VTK's wedge, the same as one of higher order, and as Exodus has it: one volume each.
TEST_F(VtuCellKinds, WedgesAreWoundAsTheirPointsLie) {
  const std::vector<double> points{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
  const std::vector<std::vector<double>> orders{{0, 2, 1, 3, 5, 4}, {0, 1, 2, 3, 4, 5}};
  for (const double type : {13.0, 73.0, 80.0}) {
    for (const auto& order : orders) {
      VtuText mesh;
      mesh.pieces = {cell_piece(points, {type}, {order})};
      const auto source = open(mesh, {.tetrahedralize = true, .linearize = true});
      const Geometry g = source->read_geometry();
      ASSERT_EQ(g.tets.size(), 3u);
      for (const Tet& tet : g.tets) {
        EXPECT_DOUBLE_EQ(determinant(std::get<Vector<Vec3<double>>>(g.points), tet).value, 1);
      }
    }
  }
}

TEST_F(VtuCellKinds, CarriesCellsOfLowerDimension) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {5, 10, 3, 10, 1},
                            {{0, 1, 2}, {0, 1, 2, 3}, {1, 4}, {4, 2, 1, 3}, {3}})};
  const Geometry g = read(mesh);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_EQ(plain(g.tet_source), (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(plain(g.lower.types), (std::vector<std::uint64_t>{5, 3, 1}));
  EXPECT_EQ(plain(g.lower.offsets), (std::vector<std::uint64_t>{0, 3, 5, 6}));
  EXPECT_EQ(plain(g.lower.connectivity), (std::vector<std::uint64_t>{0, 1, 2, 1, 4, 3}));
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{0, 2, 4}));
}

TEST_F(VtuCellKinds, TetsBeforeOtherCellsAreTheirOwnSource) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {10, 10, 5}, {{0, 1, 2, 3}, {4, 2, 1, 3}, {0, 1, 2}})};
  const Geometry g = read(mesh);
  EXPECT_TRUE(g.tet_source.empty());
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{2}));
}

TEST_F(VtuCellKinds, LinearizesTenNodeTets) {
  std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int k = 0; k < 6; ++k) xyz.insert(xyz.end(), {0.5, 0.25 * k, 0});
  VtuText mesh;
  mesh.pieces = {cell_piece(xyz, {24}, {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}})};
  const Geometry g = read(mesh, {false, true});
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_EQ(g.unused_points, 6u);
  EXPECT_EQ(coordinates<double>(g).size(), 12u);
}

TEST_F(VtuCellKinds, LinearizesEdgesAndTrianglesBesideTets) {
  std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int k = 0; k < 6; ++k) xyz.insert(xyz.end(), {0.5, 0.25 * k, 0});
  VtuText mesh;
  mesh.pieces = {cell_piece(xyz, {22, 24, 21},
                            {{0, 1, 2, 4, 5, 6}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, {3, 1, 8}})};
  const Geometry g = read(mesh, {false, true});
  EXPECT_EQ(plain(g.lower.types), (std::vector<std::uint64_t>{5, 3}));
  EXPECT_EQ(plain(g.lower.offsets), (std::vector<std::uint64_t>{0, 3, 5}));
  EXPECT_EQ(plain(g.lower.connectivity), (std::vector<std::uint64_t>{0, 1, 2, 3, 1}));
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(g.unused_points, 6u);
  EXPECT_THAT(thrown_by(open(mesh, {true, false}).get()),
              HasSubstr("cell 0 is a quadratic triangle (VTK cell type 22): use "
                        "--linearize"));
}

TEST_F(VtuCellKinds, LagrangeCellsOfFirstOrderAreLinear) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {69, 71, 68, 71, 1},
                            {{0, 1, 2}, {0, 1, 2, 3}, {1, 4}, {4, 2, 1, 3}, {3}})};
  const Geometry g = read(mesh);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_EQ(plain(g.lower.types), (std::vector<std::uint64_t>{5, 3, 1}));
  EXPECT_EQ(plain(g.lower.connectivity), (std::vector<std::uint64_t>{0, 1, 2, 1, 4, 3}));
  mesh.pieces = {cell_piece(kCoordinates, {71, 71}, {{0, 1, 2, 3}, {4, 2, 1, 3}})};
  EXPECT_THAT(tets(read(mesh)), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
}

TEST_F(VtuCellKinds, LagrangeCellsOfSecondOrderAreLinearized) {
  std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int k = 0; k < 16; ++k) xyz.insert(xyz.end(), {0.5, 0.25 * k, 0});
  VtuText mesh;
  mesh.pieces = {cell_piece(xyz, {71}, {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}})};
  EXPECT_THAT(tets(read(mesh, {false, true})), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_THAT(thrown_by(open(mesh).get()), HasSubstr("use --linearize"));
  std::vector<double> third(20);
  for (int k = 0; k < 20; ++k) third[static_cast<std::size_t>(k)] = k;
  mesh.pieces = {cell_piece(xyz, {71}, {third})};
  EXPECT_THAT(tets(read(mesh, {false, true})), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_THAT(thrown_by(open(mesh).get()),
              HasSubstr("cell 0 is a Lagrange tetrahedron (VTK cell type 71): use --linearize to"));
  mesh.pieces = {cell_piece(xyz, {71}, {{0, 1, 2}})};
  EXPECT_THAT(thrown_by(open(mesh, {false, true}).get()),
              HasSubstr("has 3 vertices, expected 4 or more for a Lagrange tetrahedron"));
}

// Numbers of vertices as in VTK's documentation; corners come first in all of them.
TEST_F(VtuCellKinds, CurvedCellsAreTheirCorners) {
  struct Kind {
    double type;
    std::size_t vertices;
    double linear;
    std::size_t corners;
  };
  const std::vector<Kind> kinds = {
      {25, 20, 12, 8}, {29, 27, 12, 8}, {33, 24, 12, 8}, {72, 27, 12, 8}, {79, 64, 12, 8},
      {26, 15, 13, 6}, {31, 12, 13, 6}, {32, 18, 13, 6}, {73, 18, 13, 6}, {80, 40, 13, 6},
      {27, 13, 14, 5}, {37, 19, 14, 5}, {74, 14, 14, 5}, {81, 30, 14, 5}, {78, 10, 10, 4},
      {23, 8, 9, 4},   {28, 9, 9, 4},   {30, 6, 9, 4},   {70, 16, 9, 4},  {77, 9, 9, 4},
      {34, 7, 5, 3},   {69, 10, 5, 3},  {76, 6, 5, 3},   {35, 4, 3, 2},   {68, 5, 3, 2},
      {75, 3, 3, 2}};
  const auto numbers = [](std::size_t count) {
    std::vector<double> all(count);
    std::iota(all.begin(), all.end(), 0.0);
    return all;
  };
  std::vector<double> xyz;
  for (std::size_t v = 0; v < 64; ++v) {
    for (const std::size_t axis : {7, 11, 13}) xyz.push_back(static_cast<double>(v * v % axis));
  }
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(kind.type);
    VtuText curved, linear;
    const std::vector<double> tet = {60, 61, 62, 63};
    curved.pieces = {cell_piece(xyz, {kind.type, 10}, {numbers(kind.vertices), tet})};
    linear.pieces = {cell_piece(xyz, {kind.linear, 10}, {numbers(kind.corners), tet})};
    const Geometry found = read(curved, {true, true}), expected = read(linear, {true, true});
    EXPECT_EQ(found.tets, expected.tets);
    EXPECT_EQ(found.lower.types, expected.lower.types);
    EXPECT_EQ(found.lower.connectivity, expected.lower.connectivity);
    EXPECT_THAT(thrown_by(open(curved, {true, false}).get()), HasSubstr("--linearize"));
    if (kind.corners >= 4 && kind.linear != 10) {
      EXPECT_THAT(thrown_by(open(curved, {false, true}).get()), HasSubstr("--tetrahedralize"));
    }
  }
}

// They are read with all that they have, before no more than their corners is kept.
TEST_F(VtuCellKinds, MemoryCountsAllVerticesOfCurvedCells) {
  const auto needed = [&](std::size_t vertices) {
    std::vector<double> ids(vertices);
    std::iota(ids.begin(), ids.end(), 0.0);
    VtuText mesh;
    mesh.pieces = {cell_piece(std::vector<double>(3 * 300, 1.0), std::vector<double>(100, 71),
                              std::vector<std::vector<double>>(100, ids))};
    return open(mesh, {.tetrahedralize = false, .linearize = true})->memory_to_read();
  };
  EXPECT_EQ(needed(286) - needed(20), 100 * 266 * sizeof(VertexId));
}

// The unit cube; as a hexahedron its vertices go round its squares.
const std::vector<double> kCube = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                   0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
const std::vector<double> kCubeCorners = {0, 1, 3, 2, 4, 5, 7, 6};

TEST_F(VtuCellKinds, CutsQuadrilateralsLikeTheCellsBelow) {
  // A side of the cube as a quadrilateral from each of its corners, and as a pixel.
  const std::vector<std::pair<double, std::vector<double>>> sides = {{9, {1, 3, 7, 5}},
                                                                     {9, {3, 7, 5, 1}},
                                                                     {9, {7, 5, 1, 3}},
                                                                     {9, {5, 1, 3, 7}},
                                                                     {8, {1, 3, 5, 7}}};
  for (const auto& [type, side] : sides) {
    VtuText mesh;
    mesh.pieces = {cell_piece(kCube, {type, 12}, {side, kCubeCorners})};
    const Geometry g = read(mesh, {true, false});
    EXPECT_EQ(plain(g.lower.types), (std::vector<std::uint64_t>{5, 5}));
    EXPECT_EQ(plain(g.lower.offsets), (std::vector<std::uint64_t>{0, 3, 6}));
    EXPECT_EQ(plain(g.lower.connectivity), (std::vector<std::uint64_t>{1, 3, 7, 1, 7, 5}));
    EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{0, 0}));
    EXPECT_EQ(g.tet_source.front(), 1u);
    EXPECT_THAT(thrown_by(open(mesh, {false, true}).get()),
                HasSubstr("use --tetrahedralize to split such cells"));
  }
  // A quadrilateral that names a vertex twice is one triangle.
  VtuText mesh;
  mesh.pieces = {cell_piece(kCube, {9, 12}, {{5, 5, 1, 3}, kCubeCorners})};
  EXPECT_EQ(plain(read(mesh, {true, false}).lower.connectivity),
            (std::vector<std::uint64_t>{1, 3, 5}));
}

TEST_F(VtuCellKinds, DropsGhostCells) {
  VtuText mesh;
  mesh.pieces = {
      tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, -1e-3}, {0, 1, 2, 3, 4, 2, 1, 3}),
      tet_piece({1, 1, -1e-3, 0, 0, 0.1, 1, 0, 0, 0, 1, 0, 0, 0, 0}, {4, 2, 3, 1, 0, 3, 2, 1})};
  // Bit 1 is a copy; 16 says that the cell is an outer one, which stays.
  mesh.pieces[0].cell_data = {{"vtkGhostType", "UInt8", {16, 1}, 1, "", "DataArray"}};
  mesh.pieces[1].cell_data = {{"vtkGhostType", "UInt8", {17, 0}, 1, "", "DataArray"}};
  const auto source = open(mesh);
  const Geometry g = source->read_geometry();
  EXPECT_EQ(g.ghost_cells, 2u);
  EXPECT_EQ(g.unused_points, 2u);
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_EQ(coordinates<double>(g), kCoordinates);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_EQ(plain(g.tet_source), (std::vector<std::uint64_t>{0, 3}));
  EXPECT_EQ(plain(g.point_source), (std::vector<std::uint64_t>{0, 1, 2, 3, 5}));
  EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kCell, 0)),
            (std::vector<std::uint8_t>{16, 0, 16, 0}));
}

TEST_F(VtuCellKinds, DropsRefinedAndHiddenCells) {
  for (const double flag : {1, 8, 32, 41}) {
    SCOPED_TRACE(flag);
    VtuText mesh;
    mesh.pieces = {tet_piece(kCoordinates, kIds)};
    mesh.pieces[0].cell_data = {{"vtkGhostType", "UInt8", {2, flag}, 1, "", "DataArray"}};
    mesh.pieces[0].point_data = {{"vtkGhostType", "UInt8", {0, 1, 2, 3, 0}, 1, "", "DataArray"}};
    const auto source = open(mesh);
    const Geometry g = source->read_geometry();
    EXPECT_EQ(g.ghost_cells, 1u);
    EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}));
    EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kCell, 0)),
              (std::vector<std::uint8_t>{2, 0}));
    // On points 2 hides, and only copies are gone.
    EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kPoint, 0)),
              (std::vector<std::uint8_t>{0, 0, 2, 2, 0}));
  }
}

TEST_F(VtuCellKinds, DropsGhostCellsOfOldFilesAndOfAnyKind) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {9, 10, 5}, {{0, 1, 2, 3}, {4, 2, 1, 3}, {2, 1, 3}})};
  mesh.pieces[0].cell_data = {{"vtkGhostLevels", "UInt8", {2, 0, 0}, 1, "", "DataArray"}};
  const Geometry g = read(mesh);
  EXPECT_EQ(g.ghost_cells, 1u);
  EXPECT_EQ(g.unused_points, 1u);
  EXPECT_THAT(tets(g), ElementsAre(Tet{3, 1, 0, 2}));
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{2}));
}

TEST_F(VtuCellKinds, TellsAnInvalidMeshFromADamagedFile) {
  for (const double id : {5.0, -1.0, 1e9}) {
    VtuText mesh;
    mesh.pieces = {tet_piece(kCoordinates, kIds),
                   cell_piece(kCoordinates, {5, 10}, {{0, 1, 2}, {0, 1, 2, 3}})};
    mesh.pieces[0].connectivity.values[6] = id;
    EXPECT_THAT(thrown_by(open(mesh).get()),
                ::testing::AllOf(StartsWith("InvalidMesh: " + path_),
                                 HasSubstr("cell 1 of piece 0 uses point")));
    mesh.pieces.erase(mesh.pieces.begin());
    mesh.pieces[0].connectivity.values[6] = id;
    EXPECT_THAT(thrown_by(open(mesh).get()), StartsWith("InvalidMesh: " + path_));
  }
  VtuText mesh;
  mesh.pieces = {tet_piece(kCoordinates, kIds)};
  mesh.pieces[0].offsets.values[0] = 5;
  EXPECT_THAT(thrown_by(open(mesh).get()), StartsWith("Error: "));
  mesh.pieces = {tet_piece(kCoordinates, {0, 1, 2, 9})};
  mesh.pieces[0].points = 6;  // the coordinates are too short, and this is the graver fault
  EXPECT_THAT(thrown_by(open(mesh).get()),
              ::testing::AllOf(StartsWith("Error: "), HasSubstr("coordinates")));
}

TEST_F(VtuCellKinds, CoordinatesThatAreNotFiniteMatterWhereTheyAreUsed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> xyz = kCoordinates;
  xyz.insert(xyz.end(), {0, nan, 0});
  VtuText mesh;
  mesh.pieces = {tet_piece(kCoordinates, kIds), tet_piece(xyz, kIds)};
  const auto source = open(mesh);
  EXPECT_EQ(source->read_geometry().unused_points, 1u);
  mesh.pieces[1].connectivity.values[0] = 5;
  EXPECT_THAT(thrown_by(open(mesh).get()),
              ::testing::AllOf(HasSubstr("InvalidMesh: "), HasSubstr("coordinates of piece 1"),
                               HasSubstr("point 5 has the y coordinate nan"), HasSubstr("(byte ")));
}

}  // namespace
}  // namespace tetfusion
