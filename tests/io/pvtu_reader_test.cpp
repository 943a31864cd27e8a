// Several files that are one mesh, beside one file that has the same pieces.
#include "io/vtk/pvtu_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_stream.h"
#include "support/meshes.h"
#include "support/stream_check.h"
#include "support/temp_dir.h"
#include "support/vtu_file_test.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using ::testing::HasSubstr;
using testing::tet_piece;
using testing::to_vtu;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;

class SeveralFiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(dir.file(name), std::ios::binary) << text;
  }
  // One file with all pieces, and one for each.
  void write_both(const VtuText& mesh, const VtuStyle& style = {}) {
    write("one.vtu", to_vtu(mesh, style));
    names.clear();
    for (std::size_t p = 0; p < mesh.pieces.size(); ++p) {
      VtuText piece = mesh;
      piece.pieces = {mesh.pieces[p]};
      names.push_back("piece " + std::to_string(p) + " & more.vtu");
      write(names.back(), to_vtu(piece, style));
    }
    write_index();
  }
  void write_index(const std::string& arrays = "") const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\">\n"
        "<PUnstructuredGrid GhostLevel=\"0\">\n" +
        arrays;
    for (const std::string& name : names) {
      const std::size_t at = name.find('&');
      text +=
          "<Piece Source=\"" +
          (at == std::string::npos ? name : name.substr(0, at) + "&amp;" + name.substr(at + 1)) +
          "\"/>\n";
    }
    write("many.pvtu", text + "</PUnstructuredGrid>\n</VTKFile>\n");
  }
  void expect_the_same() const {
    const auto one = open_mesh(dir.file("one.vtu"));
    const auto many = open_mesh(dir.file("many.pvtu"));
    EXPECT_EQ(many->description().points, one->description().points);
    EXPECT_EQ(many->description().cells, one->description().cells);
    EXPECT_EQ(many->description().point_type, one->description().point_type);
    const auto expected = testing::write_out_whole(one.get());
    EXPECT_TRUE(testing::write_out_whole(many.get()) == expected);
    const auto stream = open_stream(many.get());
    const auto of_one = open_stream(one.get());
    EXPECT_TRUE(stream->streams_from_disk());
    EXPECT_TRUE(of_one->streams_from_disk());
    EXPECT_EQ(stream->points(), of_one->points());
    EXPECT_EQ(stream->merged_points(), of_one->merged_points());
    EXPECT_EQ(stream->differing_points(), of_one->differing_points());
    EXPECT_EQ(many->read_geometry().differing_points, of_one->differing_points());
    EXPECT_EQ(stream->dropped_points(), of_one->dropped_points());
    EXPECT_EQ(stream->ghost_cells(), of_one->ghost_cells());
    EXPECT_EQ(stream->lower_cells().cells, of_one->lower_cells().cells);
    EXPECT_EQ(stream->lower_cells().corners, of_one->lower_cells().corners);
    for (const std::uint64_t window : {1, 3, 1000}) {
      EXPECT_TRUE(testing::write_out_windows(*many, *stream, window) == expected) << window;
      EXPECT_TRUE(testing::write_out_windows(*one, *of_one, window) == expected) << window;
    }
  }
  std::string error() const {
    try {
      open_mesh(dir.file("many.pvtu"))->read_geometry();
    } catch (const std::exception& e) {
      return e.what();
    }
    return "nothing";
  }

  testing::TempDir dir;
  std::vector<std::string> names;
};

// The box cut into pieces along its cells, with arrays.
VtuText cut_box(std::size_t pieces, bool ids) {
  const Geometry whole = testing::five_split_cube(3, 0.1);
  const std::size_t n = whole.tets.size();
  VtuText mesh;
  for (std::size_t p = 0; p < pieces; ++p) {
    std::vector<double> xyz, corners, global, number;
    std::map<VertexId, double> local;
    for (std::size_t t = n * p / pieces; t < n * (p + 1) / pieces; ++t) {
      for (const VertexId v : whole.tets[t]) {
        const auto [it, fresh] = local.try_emplace(v, static_cast<double>(local.size()));
        corners.push_back(it->second);
        if (!fresh) continue;
        const Vec3<double> at = testing::point(whole, v);
        // With ids, copies may differ.
        xyz.insert(xyz.end(), {at.x, at.y, at.z + (ids ? 1e-9 * static_cast<double>(p) : 0)});
        global.push_back(static_cast<double>(v) * 1000);
      }
      number.push_back(static_cast<double>(t));
    }
    mesh.pieces.push_back(tet_piece(xyz, corners));
    mesh.pieces.back().cell_data = {{"number", "Int32", number, 1, "", "DataArray"}};
    mesh.pieces.back().point_data = {
        {ids ? "GlobalNodeIds" : "value", "Int64", global, 1, "", "DataArray"}};
  }
  return mesh;
}

TEST_F(SeveralFiles, AreOneMesh) {
  for (const bool ids : {false, true}) {
    for (const std::size_t pieces : {1, 2, 5, 16}) {
      SCOPED_TRACE(pieces);
      VtuText mesh = cut_box(pieces, ids);
      if (pieces == 5) mesh.pieces.insert(mesh.pieces.begin() + 2, VtuPieceText{});  // an empty one
      write_both(mesh);
      expect_the_same();
      const auto many = open_mesh(dir.file("many.pvtu"));
      EXPECT_EQ(open_stream(many.get())->points(), 64u);
    }
  }
}

TEST_F(SeveralFiles, MayHaveTheirArraysInAnyOrder) {
  VtuText mesh = cut_box(3, false);
  for (VtuPieceText& piece : mesh.pieces) {
    auto twice = piece.cell_data[0];
    twice.name = "more";
    for (double& value : twice.values) value = 2 * value + 1;
    piece.cell_data.push_back(twice);
    auto plus = piece.point_data[0];
    plus.name = "plus";
    for (double& value : plus.values) value += 7;
    piece.point_data.push_back(plus);
  }
  write_both(mesh);
  VtuText other;
  other.pieces = {mesh.pieces[1]};
  std::swap(other.pieces[0].cell_data[0], other.pieces[0].cell_data[1]);
  std::swap(other.pieces[0].point_data[0], other.pieces[0].point_data[1]);
  write(names[1], to_vtu(other, {}));
  expect_the_same();
}

TEST_F(SeveralFiles, HaveTheUnitsOfTheFirstOrOfTheList) {
  VtuText mesh = cut_box(3, false);
  mesh.pieces[0].point_data[0].keys = testing::information_key("UNITS_LABEL", "kPa");
  mesh.pieces[1].point_data[0].keys = testing::information_key("UNITS_LABEL", "bar");
  write_both(mesh);
  const auto array = [](const std::string& name, const std::string& units) {
    return "<PDataArray type=\"Int64\" Name=\"" + name + "\">" +
           testing::information_key("UNITS_LABEL", units) + "</PDataArray>";
  };
  write_index("<PPointData>" + array("value", "psi") + array("none", "m") +
              "</PPointData><PCellData><PDataArray type=\"Int32\" Name=\"none\"/>" +
              array("number", "1") + "</PCellData>");
  expect_the_same();
  const auto many = open_mesh(dir.file("many.pvtu"));
  EXPECT_EQ(many->description().point_data.arrays[0].units, "kPa");
  EXPECT_EQ(many->description().cell_data.arrays[0].units, "1");
}

TEST_F(SeveralFiles, MayHaveGhostsUnusedPointsAndCellsOfLowerDimension) {
  VtuText mesh;
  // A crack: points 1 and 4 coincide, and the other piece has both; point 5 is used by a ghost
  // alone.
  const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 7, 7, 7};
  mesh.pieces = {
      cell_piece(xyz, {10, 5, 10, 10}, {{0, 1, 2, 3}, {0, 1, 2}, {0, 4, 2, 3}, {0, 1, 2, 5}}),
      cell_piece(xyz, {5}, {{2, 4, 3}}),
      cell_piece(xyz, {1, 10, 10}, {{3}, {0, 4, 2, 3}, {0, 1, 2, 3}})};
  mesh.pieces[0].cell_data = {{"vtkGhostType", "UInt8", {0, 0, 0, 1}, 1, "", "DataArray"}};
  mesh.pieces[1].cell_data = {{"vtkGhostType", "UInt8", {0}, 1, "", "DataArray"}};
  mesh.pieces[2].cell_data = {{"vtkGhostType", "UInt8", {0, 0, 1}, 1, "", "DataArray"}};
  write_both(mesh);
  expect_the_same();
}

TEST_F(SeveralFiles, WithOddIndicesAreRefused) {
  write_both(cut_box(2, false));
  std::filesystem::remove(dir.file(names[1]));
  EXPECT_THAT(error(), HasSubstr(names[1]));
  EXPECT_THAT(error(), HasSubstr("No such file"));
  names.clear();
  write_index();
  EXPECT_THAT(error(), HasSubstr("no <Piece>"));
  names = {""};
  write_index();
  EXPECT_THAT(error(), HasSubstr("piece 0 names no file"));
  write("many.pvtu", "<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid><Piece Source=\"x");
  EXPECT_THAT(error(), HasSubstr("damaged"));
}

// A file from a stranger opens no others.
TEST_F(SeveralFiles, ElsewhereAreRefused) {
  write_both(cut_box(2, false));
  const std::string piece = names[0];
  std::filesystem::create_directory(dir.file("below"));
  for (const std::string& elsewhere :
       {std::string("/dev/zero"), dir.file(piece), "../" + piece, "below/../../" + piece}) {
    names[0] = elsewhere;
    write_index();
    EXPECT_THAT(error(), HasSubstr(elsewhere.starts_with('/') ? "an absolute path: the file must"
                                                              : "not below the folder of this"))
        << elsewhere;
  }
  names[0] = "below/../" + piece;
  write_index();
  expect_the_same();
}

TEST_F(SeveralFiles, ThatDoNotGoTogetherAreForVtk) {
  VtuText mesh = cut_box(2, false);
  write_both(mesh);
  const auto obstacle = [&](const OpenOptions& options) -> std::string {
    std::string why;
    const auto source = open_pvtu(MappedFile::open(dir.file("many.pvtu")), options, &why);
    return source ? "none" : why;
  };
  EXPECT_EQ(obstacle({}), "none");
  mesh.pieces[1].point_data[0].name = "another";
  VtuText second = mesh;
  second.pieces = {mesh.pieces[1]};
  write(names[1], to_vtu(second, {}));
  EXPECT_EQ(obstacle({}), "a .pvtu whose pieces have other arrays than the first one");
  write(names[1], "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\">");
  EXPECT_EQ(obstacle({}), "a .pvtu of pieces that are no .vtu files");
  names.assign(kMaxPiecesRead + 1, names[0]);
  write_index();
  EXPECT_EQ(obstacle({}), "a .pvtu of more than 512 pieces");
}

TEST_F(SeveralFiles, WithCellsToSplitAreForVtk) {
  VtuText mesh;
  mesh.pieces = {
      cell_piece({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}, {12},
                 {{0, 1, 2, 3, 4, 5, 6, 7}})};
  write_both(mesh);
  std::string why;
  const OpenOptions split{true, false, {}};
  EXPECT_EQ(open_pvtu(MappedFile::open(dir.file("many.pvtu")), split, &why), nullptr);
  EXPECT_EQ(why, "a .pvtu with cells to split or straighten");
}

}  // namespace
}  // namespace tetfusion
