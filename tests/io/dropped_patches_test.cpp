// Meshes without their cells of lower dimension (OpenOptions::drop_patches).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "io/source/mesh_stream.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using ::testing::ElementsAre;
using testing::plain;
using testing::VtuText;

const OpenOptions kDropped = {.drop_patches = true};

class DroppedPatches : public testing::VtuFileTest {
 protected:
  // Point 0 is used by no cell, point 1 by the first cell and the vertex alone. The cells: a
  // triangle (or what else it is to be), a tetrahedron, a line, a tetrahedron, a vertex.
  static VtuText mesh(double first_type = 5, const std::vector<double>& first = {1, 2, 3}) {
    VtuText mesh;
    mesh.pieces = {cell_piece({9, 9, 9, 5, 5, 5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1},
                              {first_type, 10, 3, 10, 1},
                              {first, {2, 3, 4, 5}, {2, 3}, {6, 4, 3, 5}, {1}})};
    mesh.pieces[0].point_data = {{"p", "Int32", {0, 1, 2, 3, 4, 5, 6}, 1, "", "DataArray"}};
    mesh.pieces[0].cell_data = {{"c", "Int32", {10, 11, 12, 13, 14}, 1, "", "DataArray"}};
    return mesh;
  }
};

TEST_F(DroppedPatches, WindowsKeepTheNumbersOfTheFile) {
  const auto source = open(mesh(), kDropped);
  const auto stream = open_stream(source.get());
  EXPECT_TRUE(stream->streams_from_disk());
  EXPECT_EQ(stream->points(), 7u);
  EXPECT_EQ(stream->cells(), 5u);
  CellWindow window;
  stream->read_cells(0, 5, &window);
  EXPECT_THAT(std::vector<Tet>(window.tets.begin(), window.tets.end()),
              ElementsAre(Tet{2, 3, 4, 5}, Tet{6, 4, 3, 5}));
  EXPECT_THAT(plain(window.tet_rows), ElementsAre(1u, 3u));
  EXPECT_EQ(window.lower.size(), 0u);
  EXPECT_TRUE(window.lower.offsets.empty());
  EXPECT_TRUE(window.lower_rows.empty());
}

TEST_F(DroppedPatches, AWholeMeshHasNoPointsOfOtherCells) {
  const auto source = open(mesh(), kDropped);
  const Geometry whole = source->read_geometry();
  EXPECT_THAT(testing::tets(whole), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_THAT(plain(whole.tet_source), ElementsAre(1u, 3u));
  EXPECT_THAT(plain(whole.point_source), ElementsAre(2u, 3u, 4u, 5u, 6u));
  EXPECT_EQ(whole.unused_points, 2u);
  EXPECT_EQ(whole.lower.size(), 0u);
  EXPECT_TRUE(whole.lower_source.empty());
  EXPECT_EQ(testing::coordinates<double>(whole)[12], 1);  // the last point's
  EXPECT_EQ(source->read_array(Association::kCell, 0).info.tuples, 5u);
}

// A pyramid that is split has the mesh read whole.
TEST_F(DroppedPatches, WhatIsReadWholeIsTheSameInWindows) {
  VtuText text = mesh();
  text.pieces[0] = cell_piece({9, 9, 9, 5, 5, 5, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1},
                              {5, 14}, {{0, 1, 2}, {2, 3, 4, 5, 6}});
  const auto source = open(text, {.tetrahedralize = true, .drop_patches = true});
  const auto stream = open_stream(source.get());
  EXPECT_FALSE(stream->streams_from_disk());
  EXPECT_EQ(stream->points(), 5u);
  EXPECT_EQ(stream->cells(), 2u);
  EXPECT_EQ(stream->dropped_points(), 2u);
  const auto rows = open_rows(source.get());
  EXPECT_EQ(rows->points(), 5u);
}

// Whatever has no volume is left out, though it could not be read: a poly-vertex, a polyline, a
// strip, a polygon, a pixel, an empty cell, a quadratic edge.
TEST_F(DroppedPatches, MayBeOfTypesThatAreNotRead) {
  const std::vector<std::pair<double, std::vector<double>>> kinds = {
      {2, {1, 2}},
      {4, {1, 2, 3}},
      {6, {1, 2, 3, 4, 5}},
      {7, {1, 2, 3, 4, 5}},
      {8, {1, 2, 3, 4}},
      {9, {1, 2, 3, 4}},
      {0, {}},
      {21, {1, 2, 3}},
  };
  for (const auto& [type, points] : kinds) {
    SCOPED_TRACE(type);
    EXPECT_ANY_THROW(read(mesh(type, points)));
    const auto source = open(mesh(type, points), kDropped);
    const Geometry whole = source->read_geometry();
    EXPECT_THAT(testing::tets(whole), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
    EXPECT_THAT(plain(whole.tet_source), ElementsAre(1u, 3u));
    const auto stream = open_stream(source.get());
    EXPECT_TRUE(stream->streams_from_disk());
    EXPECT_EQ(stream->ghost_cells(), 0u);
    EXPECT_EQ(stream->lower_cells().cells, 0u);
    EXPECT_EQ(stream->lower_cells().corners, 0u);
    CellWindow window;
    stream->read_cells(0, 5, &window);
    EXPECT_EQ(window.tets.size(), 2u);
    EXPECT_EQ(window.lower.size(), 0u);
  }
}

TEST_F(DroppedPatches, ACellWithVolumeIsRefusedAsEver) {
  EXPECT_ANY_THROW(read(mesh(12, {1, 2, 3, 4, 5, 6, 0, 1}), kDropped));
}

TEST_F(DroppedPatches, PointsStayWhereTetrahedraUseThemAll) {
  VtuText mesh;
  mesh.pieces = {cell_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 7, 7, 7}, {10, 5},
                            {{0, 1, 2, 3}, {0, 1, 2}})};
  const Geometry whole = read(mesh, kDropped);
  EXPECT_THAT(testing::tets(whole), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_THAT(plain(whole.point_source), ElementsAre(0u, 1u, 2u, 3u));
  EXPECT_EQ(whole.unused_points, 1u);
}

}  // namespace
}  // namespace tetfusion
