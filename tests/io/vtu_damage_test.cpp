// Reading .vtu files that are wrong: every one ends in an Error that names the file, none in a
// crash.
#include <gtest/gtest.h>

#include <functional>
#include <new>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/format_files.h"
#include "support/stream_check.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using testing::replaced;
using testing::TempDir;
using testing::tet_piece;
using testing::to_vtu;
using testing::VtuArrayText;
using testing::VtuData;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;
using testing::write_file;

const std::vector<double> kFivePoints = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, -1};

VtuText small_mesh() {
  VtuPieceText p = tet_piece(kFivePoints, {0, 1, 2, 3, 4, 2, 1, 3});
  p.point_data = {{"d", "Float32", {1, 2, 3, 4, 5}, 1, "", "DataArray"}};
  p.cell_data = {{"region", "Int32", {1, 2}, 1, "", "DataArray"}};
  VtuText mesh;
  mesh.pieces = {p};
  mesh.field_data = {{"names", "String", {97, 0}, 1, " NumberOfTuples=\"1\"", "Array"}};
  return mesh;
}

VtuText two_pieces() {
  VtuText mesh = small_mesh();
  mesh.pieces.push_back(mesh.pieces[0]);
  return mesh;
}

void read_everything(const std::string& path, const OpenOptions& options) {
  const auto source = open_mesh(path, options);
  source->read_geometry();
  const MeshDescription& d = source->description();
  for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
    source->read_array(Association::kPoint, i);
  }
  for (std::size_t i = 0; i < d.cell_data.arrays.size(); ++i) {
    source->read_array(Association::kCell, i);
  }
  for (std::size_t i = 0; i < d.field_data.arrays.size(); ++i) {
    source->read_array(Association::kField, i);
  }
}

class VtuDamage : public ::testing::Test {
 protected:
  // Reads `bytes` as a file; the error must have that code, name the file and hold `words`.
  void expect_error(const std::string& bytes, const std::string& words, int code = 3,
                    const OpenOptions& options = {}) {
    write_file(path_, bytes);
    testing::expect_windows_like_whole(path_, options);
    try {
      read_everything(path_, options);
      ADD_FAILURE() << "no error, expected: " << words;
    } catch (const Error& e) {
      const std::string message = e.what();
      EXPECT_EQ(e.exit_code(), code) << message;
      EXPECT_NE(message.find(path_), std::string::npos) << message;
      EXPECT_NE(message.find(words), std::string::npos) << message << "\nexpected: " << words;
    }
  }
  void expect_error(const VtuText& mesh, const std::string& words, const VtuStyle& style = {},
                    const OpenOptions& options = {}) {
    expect_error(to_vtu(mesh, style), words, 3, options);
  }

  // True when the file could be read, false after an Error; anything else fails the test.
  bool survives(const std::string& bytes) {
    write_file(path_, bytes);
    testing::expect_windows_like_whole(path_, {true, true}, false);
    try {
      read_everything(path_, {true, true});
      return true;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(path_), std::string::npos) << e.what();
      return false;
    }
  }

  TempDir dir_;
  std::string path_ = dir_.file("mesh.vtu");
};

// A file whose every number is where a text editor would find it.
VtuStyle ascii() {
  VtuStyle style;
  style.data = VtuData::kAscii;
  return style;
}

TEST_F(VtuDamage, RefusesFilesThatAreNotThere) {
  for (const std::string& path : {dir_.file("missing.vtu"), dir_.path().string()}) {
    try {
      open_mesh(path);
      ADD_FAILURE() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.exit_code(), 4) << e.what();
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    }
  }
}

TEST_F(VtuDamage, RefusesWhatIsNotXml) {
  expect_error("", "empty");
  expect_error("hello\n", "not a VTK XML file");
  expect_error("<html></html>", "not a VTK XML file");
  expect_error(std::string(1000, '\0'), "not a VTK XML file");
}

TEST_F(VtuDamage, RefusesAHeadThatMakesNoSense) {
  const std::string good = to_vtu(small_mesh(), {});
  const std::string inline_text = to_vtu(small_mesh(), ascii());
  struct Case {
    const char* from;
    const char* to;
    const char* words;
  };
  for (const Case& c : std::vector<Case>{
           {"\"1.0\" byte", "\"9.0\" byte", "version"},
           {"LittleEndian", "MiddleEndian", "byte_order"},
           {"header_type=\"UInt64\"", "header_type=\"UInt16\"", "header_type"},
           {"header_type=\"UInt64\"", "compressor=\"vtkBz2\"", "unknown compressor"},
           {"<UnstructuredGrid>", "<PolyData>", "damaged"},
           {"<UnstructuredGrid>", "<UnstructuredGrid TimeValues=\"\n0\n0.5\n\">", "2 time steps"},
           {"encoding=\"raw\"", "encoding=\"hex\"", "encoding"},
           {"   _", "   ", "underscore"},
           {"offset=\"0\"", "offset=\"zero\"", "expected a number"},
           {"offset=\"0\"", "offset=\"999999\"", "behind the end"},
           {"offset=\"0\"", "offset=\"-1\"", "expected a number"},
           {"offset=\"0\"", "offset=\"99999999999999999999999\"", "expected a number"},
           {"NumberOfPoints=\"5\"", "NumberOfPoints=\"-5\"", "NumberOfPoints"},
           {"NumberOfPoints=\"5\"", "", "NumberOfPoints"},
           {"NumberOfPoints=\"5\"", "NumberOfPoints=\"1152921504606846976\"", "room"},
           {"NumberOfPoints=\"5\"", "NumberOfPoints=\"18446744073709551615\"", "room"},
           {"NumberOfPoints=\"5\"", "NumberOfPoints=\"4\"", "expected 12 values"},
           {"NumberOfCells=\"2\"", "NumberOfCells=\"1152921504606846976\"", "room"},
           {"NumberOfCells=\"2\"", "NumberOfCells=\"3\"", "cell array"},
           {"NumberOfCells=\"2\"", "NumberOfCells=\"0\"", "no cells"},
           {"NumberOfComponents=\"3\"", "NumberOfComponents=\"2\"", "expected 3"},
           {"NumberOfComponents=\"3\"", "NumberOfComponents=\"0\"", "NumberOfComponents"},
           {"type=\"Float32\"", "type=\"Float16\"", "unknown type"},
           {"Name=\"types\"", "Name=\"typos\"", "\"types\" is missing"},
           {"Name=\"types\"", "Name=\"offsets\"", "two arrays"},
           {"type=\"UInt8\" Name=\"types\"", "type=\"Float32\" Name=\"types\"", "integers"},
           {"format=\"appended\"", "format=\"attached\"", "unknown format"},
           {"format=\"appended\"", "format=\"ascii\"", "field array"},
           {"</FieldData>", "</fieldData>", "damaged"},
           {"<Points>", "<Pints></Pints><Points/><Points2>", "damaged"}}) {
    SCOPED_TRACE(std::string(c.from) + " -> " + c.to);
    if (std::string(c.to) == "format=\"ascii\"") {
      // An ascii array without text is an empty one: fine for strings.
      EXPECT_TRUE(survives(replaced(good, c.from, c.to)));
      continue;
    }
    expect_error(replaced(good, c.from, c.to), c.words);
  }
  expect_error(replaced(inline_text, " 97", " 97<InformationKey/> 3"), "two parts");
  expect_error(replaced(inline_text, " 97", " <![CDATA[97]]>"), "CDATA");
  expect_error(replaced(inline_text, "format=\"ascii\"", "format=\"appended\" offset=\"0\""),
               "no <AppendedData>");
  VtuText empty;
  expect_error(empty, "no <Piece>");
}

TEST_F(VtuDamage, RefusesNumbersThatAreNone) {
  const std::string good = to_vtu(small_mesh(), ascii());
  expect_error(replaced(good, " 1 2 3 4 5", " 1 2 x 4 5"), "\"x\" is not a number");
  expect_error(replaced(good, " 1 2 3 4 5", " 1 2 +-3 4 5"), "\"+-3\" is not a number");
  expect_error(replaced(good, " 1 2 3 4 5", " 1 2 3 4"), "expected 5 values, found 4");
  expect_error(replaced(good, " 1 2 3 4 5", " 1 2 3 4 5 6"), "expected 5 values, found 6");
  expect_error(replaced(good, " 1 2 3 4 5", " 1 2 1e99 4 5"), "\"1e99\"");
  expect_error(replaced(good, " 10 10", " 10 1000"), "\"1000\"");
  expect_error(replaced(good, " 10 10", " 10 10.5"), "\"10.5\"");
  EXPECT_TRUE(survives(replaced(good, " 1 2 3 4 5", " 1 2 1e-99 +4 -5.5e0")));
}

TEST_F(VtuDamage, RefusesCellsThatMakeNoSense) {
  VtuText mesh = small_mesh();
  mesh.pieces[0].connectivity.values[5] = 5;
  expect_error(mesh, "cell 1 uses point 5, but there are 5 points (byte ");
  mesh.pieces[0].connectivity.values[5] = -1;
  expect_error(mesh, "cell 1 uses point -1");
  mesh.pieces[0].connectivity.values[5] = 4294967296.0;
  expect_error(mesh, "cell 1 uses point 4294967296");
  mesh.pieces[0].connectivity.values.pop_back();
  expect_error(mesh, "has 7 values");
  mesh = small_mesh();
  mesh.pieces[0].offsets.values = {3, 8};
  expect_error(mesh, "cell 0 is a tetrahedron and must end at 4, not at 3");
  mesh = small_mesh();
  mesh.pieces[0].types.values = {10, 77};
  expect_error(mesh, "cell 1 is a");
  mesh.pieces[0].types = {"types", "Int32", {10, -3}, 1, "", "DataArray"};
  expect_error(mesh, "cell 1 has the type -3");
}

TEST_F(VtuDamage, RefusesMixedCellsThatMakeNoSense) {
  const auto mixed = [](std::vector<double> types, std::vector<std::vector<double>> cells) {
    VtuText mesh;
    mesh.pieces = {cell_piece(kFivePoints, std::move(types), std::move(cells))};
    return mesh;
  };
  const std::vector<double> tet = {0, 1, 2, 3};
  expect_error(mixed({5}, {{0, 1, 2}}), "no tetrahedra");
  expect_error(mixed({10, 5}, {tet, {0, 1}}), "cell 1 has 2 vertices, expected 3");
  expect_error(mixed({10, 5}, {tet, {0, 1, 9}}), "cell 1 uses point 9");
  expect_error(mixed({10, 7}, {tet, {0, 1, 2, 3}}), "cell 1 is a polygon");
  expect_error(mixed({10, 9}, {tet, {0, 1, 2, 3}}), "cell 1 is a quad");
  expect_error(mixed({10, 0}, {tet, {}}), "cell 1 is a");
  expect_error(mixed({10, 14}, {tet, {0, 1, 2, 3, 4}}), "--tetrahedralize");
  expect_error(mixed({24}, {{0, 1, 2, 3, 4, 0, 1, 2, 3, 4}}), "--linearize");
  VtuText backwards = mixed({5, 10}, {{0, 1, 2}, tet});
  backwards.pieces[0].offsets.values = {3, 2};
  expect_error(backwards, "cell 1 goes from 3 to 2");
  backwards.pieces[0].offsets.values = {-4, 7};
  expect_error(backwards, "cell 0 goes from 0 to -4");
  backwards.pieces[0].offsets.values = {3, 4e18};
  expect_error(backwards, "cell 1 goes from 3 to 4000000000000000000");
  VtuText longer = mixed({5, 10}, {{0, 1, 2}, tet});
  longer.pieces[0].connectivity.values.push_back(0);
  expect_error(longer, "has 8 values, but the cells end at 7");
  VtuText ghosts = mixed({10, 10}, {tet, tet});
  ghosts.pieces[0].cell_data = {{"vtkGhostType", "UInt8", {1, 1}, 1, "", "DataArray"}};
  expect_error(ghosts, "no tetrahedra");
}

TEST_F(VtuDamage, RefusesCoordinatesThatAreNotFinite) {
  for (const char* type : {"Float32", "Float64"}) {
    VtuText mesh = small_mesh();
    mesh.pieces[0].coordinates.type = type;
    for (const double bad :
         {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
          std::numeric_limits<double>::quiet_NaN()}) {
      mesh.pieces[0].coordinates.values[7] = bad;
      expect_error(mesh, "point 2 has the y coordinate ");
    }
  }
}

TEST_F(VtuDamage, RefusesArraysThatDiffer) {
  VtuText mesh = small_mesh();
  mesh.pieces[0].point_data.push_back(mesh.pieces[0].point_data[0]);
  expect_error(mesh, "two arrays called \"d\"");
  mesh = two_pieces();
  mesh.pieces[1].point_data.clear();
  expect_error(mesh, "point array \"d\" is missing in piece 1");
  mesh = two_pieces();
  mesh.pieces[0].cell_data.clear();
  expect_error(mesh, "cell array \"region\" is in piece 1");
  mesh = two_pieces();
  mesh.pieces[1].cell_data[0].type = "Int64";
  expect_error(mesh, "cell array \"region\" of piece 1 has 1 components of Int64");
  mesh = two_pieces();
  mesh.pieces[1].coordinates.type = "Float32";
  expect_error(mesh, "of piece 1 are Float32");
  mesh = two_pieces();
  mesh.pieces[1].connectivity.values[0] = 5;
  expect_error(mesh, "cell 0 of piece 1 uses point 5");
}

TEST_F(VtuDamage, RefusesTuplesThatDoNotAddUp) {
  VtuText mesh = small_mesh();
  mesh.field_data = {{"f", "Float32", {1, 2, 3}, 2, "", "DataArray"}};
  expect_error(mesh, "no whole number of tuples");
  mesh.field_data[0].attributes = " NumberOfTuples=\"2\"";
  expect_error(mesh, "expected 4 values");
  mesh.field_data[0].attributes = " NumberOfTuples=\"many\"";
  expect_error(mesh, "NumberOfTuples");
  mesh.field_data[0].attributes = " NumberOfTuples=\"4611686018427387904\"";
  expect_error(mesh, "room");
}

TEST_F(VtuDamage, RefusesDamagedBlocks) {
  for (const char* compressor :
       {"vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"}) {
    SCOPED_TRACE(compressor);
    VtuStyle style;
    style.compressor = compressor;
    const std::string good = to_vtu(small_mesh(), style);
    EXPECT_TRUE(survives(good));
    const std::size_t data = good.find("   _") + 4;  // the header of the first array follows
    const auto with_word = [&](std::size_t word, unsigned char value) {
      std::string bytes = good;
      bytes[data + 8 * word + 6] = static_cast<char>(value);  // times 2^48
      return bytes;
    };
    expect_error(with_word(0, 1), "field array \"names\"");
    expect_error(with_word(2, 1), "make no sense");
    expect_error(with_word(3, 1), "past the end");
    std::string bytes = good;
    for (std::size_t i = data + 32; i < data + 40; ++i) bytes[i] = '\x7f';
    expect_error(bytes, "is damaged");
  }
}

TEST_F(VtuDamage, RefusesWhatIsNotBase64) {
  for (const VtuData data : {VtuData::kInline, VtuData::kAppendedBase64}) {
    for (const char* compressor : {"", "vtkZLibDataCompressor"}) {
      const VtuStyle style{data, compressor, "UInt32", false, 32, "1.0"};
      const std::string good = to_vtu(small_mesh(), style);
      const std::size_t first = good.find(*compressor == '\0' ? "AgAAAGEA" : "AQAAACAA");
      ASSERT_NE(first, std::string::npos) << good;
      for (const std::size_t at : {first, first + 5, first + 7}) {
        std::string bytes = good;
        bytes[at] = '*';
        expect_error(bytes, "base64");
      }
    }
  }
}

std::vector<VtuStyle> tiny_styles() {
  return {{VtuData::kAppendedRaw, "", "UInt64", false, 32, "1.0"},
          {VtuData::kAppendedRaw, "vtkLZ4DataCompressor", "UInt32", true, 32, "1.0"},
          {VtuData::kAppendedRaw, "vtkZLibDataCompressor", "UInt32", false, 32, "1.0"},
          {VtuData::kAppendedRaw, "vtkLZMADataCompressor", "UInt32", false, 32, "1.0"},
          {VtuData::kAppendedBase64, "", "UInt32", false, 32, "1.0"},
          {VtuData::kInline, "vtkZLibDataCompressor", "UInt32", false, 32, "1.0"},
          {VtuData::kAscii, "", "", false, 32, "1.0"}};
}

TEST_F(VtuDamage, SurvivesEveryTruncation) {
  for (const VtuStyle& style : tiny_styles()) {
    SCOPED_TRACE(testing::describe(style));
    const std::string good = to_vtu(small_mesh(), style);
    EXPECT_TRUE(survives(good));
    const bool appended =
        style.data == VtuData::kAppendedRaw || style.data == VtuData::kAppendedBase64;
    // Behind the last array's last byte nothing is missing but end tags.
    const std::size_t needed = appended ? good.rfind("\n</AppendedData>") : good.rfind("</VTKFile");
    for (std::size_t length = 0; length < needed; ++length) {
      EXPECT_FALSE(survives(good.substr(0, length))) << length;
    }
  }
}

TEST_F(VtuDamage, SurvivesEveryFlippedByte) {
  for (const VtuStyle& style : tiny_styles()) {
    SCOPED_TRACE(testing::describe(style));
    const std::string good = to_vtu(small_mesh(), style);
    for (std::size_t at = 0; at < good.size(); ++at) {
      std::string bytes = good;
      for (const int mask : {0x01, 0x80, 0xff}) {
        bytes[at] = static_cast<char>(good[at] ^ mask);
        survives(bytes);
      }
    }
  }
}

}  // namespace
}  // namespace tetfusion
