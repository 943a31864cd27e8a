// Reading .vtu files that are right, in all their encodings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/mesh_source.h"
#include "support/meshes.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using testing::describe;
using ::testing::ElementsAre;
using testing::TempDir;
using testing::tet_piece;
using testing::to_vtu;
using testing::VtuArrayText;
using testing::VtuData;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;
using testing::write_file;

// Two tetrahedra that share a triangle.
const std::vector<double> kCoordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, -1e-3};
const std::vector<double> kIds = {0, 1, 2, 3, 4, 2, 1, 3};

VtuText small_mesh(const std::string& point_type, const std::string& index_type) {
  VtuPieceText p = tet_piece(kCoordinates, kIds, point_type, index_type);
  p.point_attributes = " Scalars=\"density\" Vectors=\"v\"";
  p.point_data = {{"density", "Float64", {0.1, -2, 3.5, 1e300, -0.0}, 1, "", "DataArray"},
                  {"v",
                   "Int16",
                   {1, -2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, -15},
                   3,
                   " ComponentName0=\"a&lt;b\" ComponentName2=\"c\"",
                   "DataArray"}};
  p.cell_data = {{"region", "UInt8", {7, 255}, 1, "", "DataArray"}};
  VtuText mesh;
  mesh.pieces = {p};
  mesh.field_data = {{"TimeValue", "Float64", {2.5}, 1, " NumberOfTuples=\"1\"", "DataArray"},
                     {"untold", "Int32", {1, 2, 3, 4}, 2, "", "DataArray"},
                     {"names", "String", {97, 98, 0, 99, 0}, 1, " NumberOfTuples=\"2\"", "Array"}};
  return mesh;
}

template <class T>
std::vector<T> values(const DataArray& array) {
  const auto span = array.as<T>();
  return {span.begin(), span.end()};
}

template <class Real>
std::vector<double> coordinates(const Geometry& mesh) {
  std::vector<double> out;
  for (const Vec3<Real>& p : std::get<Vector<Vec3<Real>>>(mesh.points)) {
    out.insert(out.end(), {p.x, p.y, p.z});
  }
  return out;
}

std::vector<double> as_float(std::vector<double> v) {
  for (double& x : v) x = static_cast<float>(x);
  return v;
}

std::vector<Tet> tets(const Geometry& mesh) { return {mesh.tets.begin(), mesh.tets.end()}; }

template <class T>
std::vector<std::uint64_t> plain(const Vector<T>& v) {
  return {v.begin(), v.end()};
}

// What is thrown by reading: "InvalidMesh: ..." or "Error: ...".
std::string thrown_by(MeshSource* source) {
  try {
    source->read_geometry();
  } catch (const InvalidMesh& e) {
    return std::string("InvalidMesh: ") + e.what();
  } catch (const Error& e) {
    return std::string("Error: ") + e.what();
  }
  return "nothing";
}

class VtuReader : public ::testing::Test {
 protected:
  std::unique_ptr<MeshSource> open(const std::string& bytes, const OpenOptions& options = {}) {
    write_file(path_, bytes);
    return open_mesh(path_, options);
  }
  std::unique_ptr<MeshSource> open(const VtuText& mesh, const OpenOptions& options = {},
                                   const VtuStyle& style = {}) {
    return open(to_vtu(mesh, style), options);
  }
  Geometry read(const VtuText& mesh, const OpenOptions& options = {}) {
    return open(mesh, options)->read_geometry();
  }

  TempDir dir_;
  std::string path_ = dir_.file("mesh.vtu");
};

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
  EXPECT_EQ(values<std::int16_t>(source->read_array(Association::kPoint, 1)),
            (std::vector<std::int16_t>{1, -2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, -15}));
  EXPECT_EQ(values<std::uint8_t>(source->read_array(Association::kCell, 0)),
            (std::vector<std::uint8_t>{7, 255}));

  ASSERT_EQ(d.field_data.arrays.size(), 3u);
  EXPECT_EQ(values<double>(source->read_array(Association::kField, 0)), std::vector<double>{2.5});
  EXPECT_EQ(d.field_data.arrays[1].tuples, 2u);
  EXPECT_EQ(values<std::int32_t>(source->read_array(Association::kField, 1)),
            (std::vector<std::int32_t>{1, 2, 3, 4}));
  EXPECT_EQ(d.field_data.arrays[2].tuples, 2u);
  EXPECT_EQ(values<char>(source->read_array(Association::kField, 2)),
            (std::vector<char>{'a', 'b', 0, 'c', 0}));
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

TEST_F(VtuReader, DropsUnusedPoints) {
  VtuText mesh;
  mesh.pieces = {tet_piece({9, 9, 9, 0, 0, 0, 1, 0, 0, 8, 8, 8, 0, 1, 0, 0, 0, 1}, {1, 2, 4, 5})};
  const Geometry g = read(mesh);
  EXPECT_EQ(g.unused_points, 2u);
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_EQ(plain(g.point_source), (std::vector<std::uint64_t>{1, 2, 4, 5}));
  EXPECT_EQ(coordinates<double>(g), (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
}

TEST_F(VtuReader, CarriesCellsOfLowerDimension) {
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

TEST_F(VtuReader, TetsBeforeOtherCellsAreTheirOwnSource) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {10, 10, 5}, {{0, 1, 2, 3}, {4, 2, 1, 3}, {0, 1, 2}})};
  const Geometry g = read(mesh);
  EXPECT_TRUE(g.tet_source.empty());
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{2}));
}

TEST_F(VtuReader, LinearizesTenNodeTets) {
  std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int k = 0; k < 6; ++k) xyz.insert(xyz.end(), {0.5, 0.25 * k, 0});
  VtuText mesh;
  mesh.pieces = {cell_piece(xyz, {24}, {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}})};
  const Geometry g = read(mesh, {false, true});
  EXPECT_THAT(tets(g), ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_EQ(g.unused_points, 6u);
  EXPECT_EQ(coordinates<double>(g).size(), 12u);
}

TEST_F(VtuReader, LinearizesEdgesAndTrianglesBesideTets) {
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
              ::testing::HasSubstr("cell 0 is a quadratic triangle (VTK cell type 22): use "
                                   "--linearize"));
}

// The unit cube; as a hexahedron its vertices go round its squares.
const std::vector<double> kCube = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                   0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
const std::vector<double> kCubeCorners = {0, 1, 3, 2, 4, 5, 7, 6};

TEST_F(VtuReader, CutsQuadrilateralsLikeTheCellsBelow) {
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
                ::testing::HasSubstr("use --tetrahedralize to split such cells"));
  }
  // A quadrilateral that names a vertex twice is one triangle.
  VtuText mesh;
  mesh.pieces = {cell_piece(kCube, {9, 12}, {{5, 5, 1, 3}, kCubeCorners})};
  EXPECT_EQ(plain(read(mesh, {true, false}).lower.connectivity),
            (std::vector<std::uint64_t>{1, 3, 5}));
}

TEST_F(VtuReader, SplitsHexahedraAcrossPiecesAlike) {
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

TEST_F(VtuReader, MergesPiecesByCoordinates) {
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

TEST_F(VtuReader, MergesPiecesByGlobalIds) {
  // The coordinates differ by rounding; the ids agree. The attribute marks the array, or its name
  // does.
  for (const bool marked : {false, true}) {
    const std::string name = marked ? "ids" : "GlobalNodeIds";
    VtuText mesh;
    mesh.pieces = {tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {0, 1, 2, 3}),
                   tet_piece({1, 1, 0, 0, 0, 0.2, 1, 0, 0.1, 0, 1, 0.1}, {0, 3, 2, 1})};
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

TEST_F(VtuReader, CutIntoPiecesIsTheSameMesh) {
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

TEST_F(VtuReader, NeverMergesWithinAPiece) {
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

TEST_F(VtuReader, DropsGhostCells) {
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

TEST_F(VtuReader, DropsRefinedAndHiddenCells) {
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

TEST_F(VtuReader, TellsAnInvalidMeshFromADamagedFile) {
  using ::testing::HasSubstr;
  using ::testing::StartsWith;
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

TEST_F(VtuReader, CoordinatesThatAreNotFiniteMatterWhereTheyAreUsed) {
  using ::testing::HasSubstr;
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

TEST_F(VtuReader, DropsGhostCellsOfOldFilesAndOfAnyKind) {
  VtuText mesh;
  mesh.pieces = {cell_piece(kCoordinates, {9, 10, 5}, {{0, 1, 2, 3}, {4, 2, 1, 3}, {2, 1, 3}})};
  mesh.pieces[0].cell_data = {{"vtkGhostLevels", "UInt8", {2, 0, 0}, 1, "", "DataArray"}};
  const Geometry g = read(mesh);
  EXPECT_EQ(g.ghost_cells, 1u);
  EXPECT_EQ(g.unused_points, 1u);
  EXPECT_THAT(tets(g), ElementsAre(Tet{3, 1, 0, 2}));
  EXPECT_EQ(plain(g.lower_source), (std::vector<std::uint64_t>{2}));
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
