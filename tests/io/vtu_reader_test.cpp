// Reading .vtu files that are right, in all their encodings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::coordinates;
using testing::describe;
using ::testing::ElementsAre;
using testing::information_key;
using testing::kCoordinates;
using testing::kIds;
using testing::TempDir;
using testing::tet_piece;
using testing::tets;
using testing::to_vtu;
using testing::values;
using testing::VtuArrayText;
using testing::VtuData;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;
using testing::write_file;

VtuText small_mesh(const std::string& point_type, const std::string& index_type) {
  VtuPieceText p = tet_piece(kCoordinates, kIds, point_type, index_type);
  p.point_attributes = " Scalars=\"density\" Vectors=\"v\"";
  p.point_data = {{"density", "Float64", {0.1, -2, 3.5, 1e300, -0.0}, 1, "", "DataArray"},
                  {"v",
                   "Int16",
                   {1, -2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, -15},
                   3,
                   " ComponentName0=\"a&lt;b\" ComponentName2=\"c\"",
                   "DataArray",
                   information_key("L2_NORM_RANGE", "<Value index=\"0\">1</Value>") +
                       information_key("UNITS_LABEL", "\xC2\xB0 &lt;m/s&gt;")}};
  const std::string elsewhere =
      "<InformationKey name=\"UNITS_LABEL\" location=\"other\">no</InformationKey>";
  p.cell_data = {{"region", "UInt8", {7, 255}, 1, "", "DataArray", elsewhere}};
  VtuText mesh;
  mesh.pieces = {p};
  mesh.field_data = {{"TimeValue",
                      "Float64",
                      {2.5},
                      1,
                      " NumberOfTuples=\"1\"",
                      "DataArray",
                      information_key("UNITS_LABEL", "s")},
                     {"untold", "Int32", {1, 2, 3, 4}, 2, "", "DataArray"},
                     {"names", "String", {97, 98, 0, 99, 0}, 1, " NumberOfTuples=\"2\"", "Array"}};
  return mesh;
}

class VtuReader : public testing::VtuFileTest {};

std::vector<double> as_float(std::vector<double> v) {
  for (double& x : v) x = static_cast<float>(x);
  return v;
}

void expect_small_mesh(MeshSource* source, bool float32) {
  const MeshDescription& d = source->description();
  EXPECT_EQ(d.points, 5u);
  EXPECT_EQ(d.cells, 2u);
  EXPECT_EQ(d.point_type, float32 ? ValueType::kFloat32 : ValueType::kFloat64);
  const Geometry mesh = source->read_geometry();
  if (float32) {
    EXPECT_EQ(coordinates<float>(mesh), as_float(kCoordinates));
  } else {
    EXPECT_EQ(coordinates<double>(mesh), kCoordinates);
  }
  EXPECT_THAT(tets(mesh), ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 2, 1, 3}));
  EXPECT_TRUE(mesh.point_source.empty());
  EXPECT_TRUE(mesh.tet_source.empty());
  EXPECT_EQ(mesh.lower.size(), 0u);

  ASSERT_EQ(d.point_data.arrays.size(), 2u);
  EXPECT_EQ(d.point_data.arrays[0].tuples, 5u);
  EXPECT_EQ(d.point_data.active.at("Scalars"), "density");
  EXPECT_EQ(d.point_data.active.at("Vectors"), "v");
  EXPECT_EQ(values<double>(source->read_array(Association::kPoint, 0)),
            (std::vector<double>{0.1, -2, 3.5, 1e300, -0.0}));
  EXPECT_THAT(d.point_data.arrays[1].component_names, ElementsAre("a<b", "", "c"));
  EXPECT_EQ(d.point_data.arrays[0].units, "");
  EXPECT_EQ(d.point_data.arrays[1].units, "\xC2\xB0 <m/s>");
  EXPECT_EQ(source->read_array(Association::kPoint, 1).info.units, "\xC2\xB0 <m/s>");
  EXPECT_EQ(d.cell_data.arrays[0].units, "");
  EXPECT_EQ(values<std::int16_t>(source->read_array(Association::kPoint, 1)),
            (std::vector<std::int16_t>{1, -2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, -15}));
  EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kCell, 0)),
            (std::vector<std::uint8_t>{7, 255}));

  ASSERT_EQ(d.field_data.arrays.size(), 3u);
  EXPECT_EQ(d.field_data.arrays[0].units, "s");
  EXPECT_EQ(values<double>(source->read_array(Association::kField, 0)), std::vector<double>{2.5});
  EXPECT_EQ(d.field_data.arrays[1].tuples, 2u);
  EXPECT_EQ(values<std::int32_t>(source->read_array(Association::kField, 1)),
            (std::vector<std::int32_t>{1, 2, 3, 4}));
  EXPECT_EQ(d.field_data.arrays[2].tuples, 2u);
  EXPECT_EQ(values<char>(source->read_array(Association::kField, 2)),
            (std::vector<char>{'a', 'b', 0, 'c', 0}));
}

// As VTK writes them, where characters have signs.
TEST_F(VtuReader, TextMayHaveNegativeCharacters) {
  VtuText mesh = small_mesh("Float64", "Int64");
  mesh.field_data = {{"names", "String", {-61, 182, 0}, 1, " NumberOfTuples=\"1\"", "Array"}};
  const VtuStyle ascii{VtuData::kAscii, "", "", false, 16, "0.1"};
  const auto source = open(mesh, {}, ascii);
  EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kField, 0)),
            (std::vector<std::uint8_t>{0xc3, 0xb6, 0}));
  for (const double wrong : {-129, 256}) {
    mesh.field_data[0].values[0] = wrong;
    EXPECT_THROW(open(mesh, {}, ascii)->read_array(Association::kField, 0), Error);
  }
}

TEST_F(VtuReader, ReadsEveryEncoding) {
  for (const VtuData data :
       {VtuData::kAppendedRaw, VtuData::kAppendedBase64, VtuData::kInline, VtuData::kAscii}) {
    for (const char* compressor :
         {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"}) {
      for (const char* header : {"", "UInt32", "UInt64"}) {
        for (const bool big_endian : {false, true}) {
          const VtuStyle style{data, compressor, header, big_endian, 16, "0.1"};
          for (const char* index : {"Int32", "Int64", "UInt32", "UInt64", "Int16", "UInt8"}) {
            const bool float32 = index[0] == 'I';
            SCOPED_TRACE(describe(style) + ", " + index);
            const auto source = open(small_mesh(float32 ? "Float32" : "Float64", index), {}, style);
            expect_small_mesh(source.get(), float32);
          }
        }
      }
    }
  }
}

TEST_F(VtuReader, TakesNoMoreThanALabelForUnits) {
  VtuText mesh = small_mesh("Float64", "Int64");
  const auto units_for = [&](const std::string& keys, VtuData data) {
    mesh.pieces[0].point_data[0].keys = keys;
    VtuStyle style;
    style.data = data;
    return open(mesh, {}, style)->description().point_data.arrays[0].units;
  };
  for (const VtuData data : {VtuData::kAppendedRaw, VtuData::kInline, VtuData::kAscii}) {
    EXPECT_EQ(units_for(information_key("UNITS_LABEL", ""), data), "");
    EXPECT_EQ(units_for("<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\"/>", data),
              "");
    EXPECT_EQ(units_for(information_key("UNITS_LABEL", "<Value index=\"0\">m</Value>"), data), "");
    EXPECT_EQ(units_for(information_key("UNITS_LABEL", std::string(5000, 'm')), data), "");
    EXPECT_EQ(units_for(information_key("UNITS_LABEL", "m <!-- of what -->"), data), "m");
  }
}

TEST_F(VtuReader, ReadsBlocksOfAnySize) {
  // 12 bytes is no multiple of a Float64, 16 fits the last block exactly, 1000 holds all.
  for (const std::size_t block : {1, 12, 16, 40, 1000}) {
    SCOPED_TRACE(block);
    VtuStyle style;
    style.compressor = "vtkZLibDataCompressor";
    style.block_bytes = block;
    expect_small_mesh(open(small_mesh("Float64", "Int64"), {}, style).get(), false);
  }
}

TEST_F(VtuReader, ReadsEveryVersion) {
  for (const char* version : {"0.1", "1.0", "2.0", "2.2"}) {
    VtuStyle style;
    style.version = version;
    expect_small_mesh(open(small_mesh("Float32", "Int64"), {}, style).get(), true);
  }
}

TEST_F(VtuReader, SaysWhatTheFormatIs) {
  VtuStyle style{VtuData::kAppendedRaw, "vtkZLibDataCompressor", "UInt64", true, 32, "1.0"};
  EXPECT_EQ(open(small_mesh("Float32", "Int64"), {}, style)->description().format,
            "VTK XML unstructured grid, appended raw, zlib, UInt64 headers, big-endian");
}

TEST_F(VtuReader, ReadsBase64InLinesAndHeadersEncodedApart) {
  VtuStyle style;
  style.data = VtuData::kInline;
  std::string text = to_vtu(small_mesh("Float32", "Int64"), style);
  for (std::size_t at = text.find("AAAA"); at != std::string::npos;
       at = text.find("AAAA", at + 5)) {
    text.insert(at + 2, "\n  ");
  }
  expect_small_mesh(open(text).get(), true);

  // 13 as a UInt32 header in its own groups, then the value itself, as some writers do.
  VtuText mesh = small_mesh("Float32", "Int64");
  mesh.field_data.resize(1);
  style.header_type = "UInt32";
  text = to_vtu(mesh, style);
  const std::string joined = "CAAAAAAAAAAAAARA";  // 8, 2.5
  const std::size_t at = text.find(joined);
  ASSERT_NE(at, std::string::npos) << text;
  text.replace(at, joined.size(), "CAAAAA==AAAAAAAABEA=");
  EXPECT_EQ(values<double>(open(text)->read_array(Association::kField, 0)),
            std::vector<double>{2.5});
}

// One tetrahedron: its array of types has one byte, which ends in the same base64 group as the
// header.
TEST_F(VtuReader, ReadsAnArrayOfOneByte) {
  VtuText mesh;
  mesh.pieces.push_back(tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 1, 2, 3}));
  for (const VtuData data : {VtuData::kInline, VtuData::kAppendedBase64, VtuData::kAppendedRaw}) {
    for (const char* header : {"UInt32", "UInt64"}) {
      VtuStyle style;
      style.data = data;
      style.header_type = header;
      EXPECT_EQ(open(mesh, {}, style)->read_geometry().tets.size(), 1u) << describe(style);
    }
  }
}

TEST_F(VtuReader, AFileShortenedUnderItIsAnError) {
  const std::string text = to_vtu(small_mesh("Float32", "Int64"), {});
  const TempDir dir;
  const std::string path = dir.file("mesh.vtu");
  // Long enough for pages to be missing, not only the end of one.
  std::ofstream(path, std::ios::binary) << text << std::string(100000, ' ');
  for (const std::size_t left : {text.size() + 50000, text.size() / 2, std::size_t{0}}) {
    const auto source = open_mesh(path);
    std::filesystem::resize_file(path, left);
    try {
      source->read_geometry();
      FAIL() << "nothing was thrown with " << left << " bytes left";
    } catch (const Error& e) {
      EXPECT_EQ(e.exit_code(), 4) << e.what();
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos);
      EXPECT_NE(std::string(e.what()).find("shortened"), std::string::npos) << e.what();
    }
    std::ofstream(path, std::ios::binary) << text << std::string(100000, ' ');
  }
}

TEST_F(VtuReader, ReadsArraysOfManyChunks) {
  // Long enough for several chunks in every encoding: a row of tetrahedra along x.
  const std::size_t n = 40000;
  std::vector<double> xyz;
  std::vector<double> ids;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i);
    xyz.insert(xyz.end(), {x, x / 7, x * x});
    if (i + 3 < n) ids.insert(ids.end(), {x, x + 1, x + 2, x + 3});
  }
  VtuText mesh;
  mesh.pieces = {tet_piece(xyz, ids)};
  for (const VtuStyle& style :
       {VtuStyle{}, VtuStyle{VtuData::kInline, "", "UInt32", true, 0, "1.0"},
        VtuStyle{VtuData::kAscii, "", "", false, 0, "1.0"},
        VtuStyle{VtuData::kAppendedBase64, "vtkLZ4DataCompressor", "UInt64", false, 32768,
                 "1.0"}}) {
    SCOPED_TRACE(describe(style));
    const Geometry g = open(mesh, {}, style)->read_geometry();
    EXPECT_EQ(coordinates<double>(g), xyz);
    ASSERT_EQ(g.tets.size(), n - 3);
    for (VertexId i = 0; i < n - 3; ++i) ASSERT_EQ(g.tets[i], (Tet{i, i + 1, i + 2, i + 3}));
  }
}

TEST_F(VtuReader, ReadsNumbersAsPeopleWriteThem) {
  VtuStyle style;
  style.data = VtuData::kAscii;
  std::string text = to_vtu(small_mesh("Float64", "Int64"), style);
  const std::size_t at = text.find(" 2.5\n");
  text.replace(at, 5, "\t+25e-1\n");
  expect_small_mesh(open(text).get(), false);
}

TEST_F(VtuReader, ReadsIntegerCoordinates) {
  VtuText mesh;
  mesh.pieces = {tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 1, 2, 3}, "Int32")};
  const auto source = open(mesh);
  EXPECT_EQ(source->description().point_type, ValueType::kFloat64);
  EXPECT_EQ(coordinates<double>(source->read_geometry()),
            (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
}

TEST_F(VtuReader, ChoosesByContentNotByName) {
  path_ = dir_.file("mesh.dat");
  expect_small_mesh(open(small_mesh("Float32", "Int64")).get(), true);
}

TEST_F(VtuReader, ReadsStandardInput) {
  write_file(path_, to_vtu(small_mesh("Float32", "Int64"), {}));
  const int saved = ::dup(STDIN_FILENO);
  ASSERT_NE(std::freopen(path_.c_str(), "r", stdin), nullptr);
  const auto source = open_mesh("-");
  ::dup2(saved, STDIN_FILENO);
  ::close(saved);
  EXPECT_EQ(source->description().path, "-");
  expect_small_mesh(source.get(), true);
}

TEST_F(VtuReader, ReadsTheRealMeshes) {
  const std::string folder = std::string(TETFUSION_TEST_DATA) + "/";
  if (!std::ifstream(folder + "bluntfin.vtu")) GTEST_SKIP() << "no " << folder;
  const auto source = open_mesh(folder + "bluntfin.vtu");
  const Geometry g = source->read_geometry();
  EXPECT_EQ(g.tets.size(), 187395u);
  EXPECT_EQ(point_count(g.points), 40960u);
  EXPECT_EQ(source->description().point_data.arrays.size(), 4u);
}

}  // namespace
}  // namespace tetfusion
