// Reading meshes in windows. That windows give the same mesh as reading it at once is tested for
// every file of the other tests of readers, too (VtuFileTest).
#include "io/source/mesh_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "support/meshes.h"
#include "support/stream_check.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::cell_piece;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kCoordinates;
using testing::kIds;
using testing::plain;
using testing::tet_piece;
using testing::to_vtu;
using testing::VtuData;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;

class MeshStreams : public testing::VtuFileTest {};

std::vector<Tet> tets_of(const CellWindow& window) {
  return {window.tets.begin(), window.tets.end()};
}

// Vertices, lines, triangles and tetrahedra in turns, with an array that numbers the cells.
VtuText mixed_mesh(std::size_t cells) {
  const std::size_t points = cells + 3;
  std::vector<double> xyz(3 * points);
  std::iota(xyz.begin(), xyz.end(), 0.0);
  std::vector<double> types;
  std::vector<std::vector<double>> ids;
  std::vector<double> numbers(cells);
  std::iota(numbers.begin(), numbers.end(), 0.0);
  const std::vector<std::pair<double, std::size_t>> kinds = {
      {10, 4}, {5, 3}, {10, 4}, {3, 2}, {1, 1}};
  for (std::size_t c = 0; c < cells; ++c) {
    const auto& [type, size] = kinds[c % kinds.size()];
    types.push_back(type);
    ids.emplace_back(size);
    std::iota(ids.back().begin(), ids.back().end(), static_cast<double>(c));
  }
  VtuText mesh;
  mesh.pieces = {cell_piece(xyz, types, ids)};
  mesh.pieces[0].cell_data = {{"number", "Int32", numbers, 1, "", "DataArray"}};
  return mesh;
}

TEST_F(MeshStreams, KeepsTheNumbersOfTheFile) {
  VtuText mesh;
  // Point 0 is used by no cell; the first cell is a ghost.
  mesh.pieces = {cell_piece({9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, -1}, {10, 5, 10, 1},
                            {{1, 2, 3, 4}, {1, 2, 3}, {5, 3, 2, 4}, {2}})};
  mesh.pieces[0].cell_data = {{"vtkGhostType", "UInt8", {1, 0, 16, 0}, 1, "", "DataArray"}};
  const auto source = open(mesh);
  const auto stream = open_stream(source.get());
  EXPECT_TRUE(stream->streams_from_disk());
  EXPECT_EQ(stream->points(), 6u);
  EXPECT_EQ(stream->cells(), 4u);
  EXPECT_EQ(stream->ghost_cells(), 1u);
  EXPECT_EQ(stream->lower_cells().cells, 2u);
  EXPECT_EQ(stream->lower_cells().corners, 4u);
  EXPECT_EQ(stream->dropped_points(), 0u);
  EXPECT_EQ(stream->merged_points(), 0u);
  CellWindow w;
  stream->read_cells(0, 4, &w);
  EXPECT_THAT(tets_of(w), ElementsAre(Tet{5, 3, 2, 4}));
  EXPECT_EQ(plain(w.tet_rows), (std::vector<std::uint64_t>{2}));
  EXPECT_EQ(plain(w.lower.types), (std::vector<std::uint64_t>{5, 1}));
  EXPECT_EQ(plain(w.lower.offsets), (std::vector<std::uint64_t>{0, 3, 4}));
  EXPECT_EQ(plain(w.lower.connectivity), (std::vector<std::uint64_t>{1, 2, 3, 2}));
  EXPECT_EQ(plain(w.lower_rows), (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(w.ghost_cells, 1u);
  // A window replaces what was there, and has rows only where they are not first + i.
  stream->read_cells(2, 1, &w);
  EXPECT_THAT(tets_of(w), ElementsAre(Tet{5, 3, 2, 4}));
  EXPECT_TRUE(w.tet_rows.empty());
  EXPECT_EQ(w.lower.size(), 0u);
  EXPECT_EQ(w.ghost_cells, 0u);
  stream->read_cells(4, 0, &w);
  EXPECT_TRUE(w.tets.empty());
  Vector<std::byte> flags(4);
  stream->read_rows(Association::kCell, 0, 0, 4, flags);
  EXPECT_EQ(flags[0], std::byte{0});
  EXPECT_EQ(flags[2], std::byte{16});
}

// A source that gives no windows.
class OnlyWhole final : public MeshSource {
 public:
  explicit OnlyWhole(MeshSource* source) : source_(source) {}
  const MeshDescription& description() const override { return source_->description(); }
  Geometry read_geometry() override { return source_->read_geometry(); }
  DataArray read_array(Association association, std::size_t index) override {
    return source_->read_array(association, index);
  }

 private:
  MeshSource* source_;
};

TEST_F(MeshStreams, NumbersAWholeMeshTetrahedraFirst) {
  VtuText mesh;
  mesh.pieces = {
      cell_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {5, 10}, {{0, 1, 2}, {0, 1, 2, 3}}),
      cell_piece({1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, 0}, {10, 1}, {{3, 1, 0, 2}, {3}})};
  mesh.pieces[0].cell_data = {{"n", "Int32", {10, 11}, 1, "", "DataArray"}};
  mesh.pieces[1].cell_data = {{"n", "Int32", {12, 13}, 1, "", "DataArray"}};
  const auto in_file = open(mesh);
  const auto source = std::make_unique<OnlyWhole>(in_file.get());
  std::uint64_t reserved = 0;
  const auto stream = open_stream(source.get(), [&](std::uint64_t bytes) { reserved = bytes; });
  EXPECT_EQ(reserved, source->memory_to_read());
  EXPECT_GT(reserved, 100u);
  EXPECT_FALSE(stream->streams_from_disk());
  EXPECT_EQ(stream->points(), 5u);
  EXPECT_EQ(stream->merged_points(), 3u);
  EXPECT_EQ(stream->cells(), 4u);
  CellWindow w;
  stream->read_cells(1, 2, &w);
  EXPECT_THAT(tets_of(w), ElementsAre(Tet{4, 2, 1, 3}));
  EXPECT_TRUE(w.tet_rows.empty());
  EXPECT_EQ(plain(w.lower.connectivity), (std::vector<std::uint64_t>{0, 1, 2}));
  EXPECT_EQ(plain(w.lower_rows), (std::vector<std::uint64_t>{2}));
  std::vector<std::int32_t> numbers(4);
  stream->read_rows(Association::kCell, 0, 0, 4, std::as_writable_bytes(std::span(numbers)));
  EXPECT_THAT(numbers, ElementsAre(11, 12, 10, 13));
}

TEST_F(MeshStreams, SplitsAndLinearizesOnlyWhereTheFileHasSuchCells) {
  VtuText mesh;
  mesh.pieces = {tet_piece(kCoordinates, kIds)};
  EXPECT_TRUE(open_stream(open(mesh, {true, true}).get())->streams_from_disk());
  mesh.pieces = {cell_piece(kCoordinates, {10, 14}, {{0, 1, 2, 3}, {0, 1, 2, 3, 4}})};
  EXPECT_FALSE(open_stream(open(mesh, {true, true}).get())->streams_from_disk());
}

TEST_F(MeshStreams, ThrowsForWindowsOutsideTheMesh) {
  VtuText mesh;
  for (int pieces = 1; pieces <= 2; ++pieces) {
    mesh.pieces.push_back(tet_piece(kCoordinates, kIds));
    mesh.pieces.back().point_data = {{"a", "Float32", {1, 2, 3, 4, 5}, 1, "", "DataArray"}};
    const auto source = open(mesh);
    const auto stream = open_stream(source.get());
    CellWindow w;
    EXPECT_THROW(stream->read_cells(stream->cells(), 1, &w), std::out_of_range);
    EXPECT_THROW(stream->read_cells(1, stream->cells(), &w), std::out_of_range);
    EXPECT_THROW(stream->read_cells(~std::uint64_t{0}, 2, &w), std::out_of_range);
    Vector<std::byte> out(100);
    EXPECT_THROW(stream->read_points(3, 3, out), std::out_of_range);
    EXPECT_THROW(stream->read_rows(Association::kPoint, 0, 5, 1, out), std::out_of_range);
    EXPECT_THROW(stream->read_rows(Association::kPoint, 1, 0, 1, out), std::out_of_range);
  }
}

TEST_F(MeshStreams, OtherWindowsOfABadFileCanBeRead) {
  VtuText mesh;
  mesh.pieces = {tet_piece(kCoordinates, kIds)};
  mesh.pieces[0].connectivity.values[6] = 7;
  const auto source = open(mesh);
  const auto stream = open_stream(source.get());
  CellWindow w;
  stream->read_cells(0, 1, &w);
  EXPECT_THAT(tets_of(w), ElementsAre(Tet{0, 1, 2, 3}));
  try {
    stream->read_cells(1, 1, &w);
    FAIL();
  } catch (const InvalidMesh& e) {
    EXPECT_THAT(e.what(), HasSubstr("cell 1 uses point 7, but there are 5 points"));
  }
}

std::vector<VtuStyle> all_styles() {
  std::vector<VtuStyle> styles;
  for (const VtuData data :
       {VtuData::kAppendedRaw, VtuData::kAppendedBase64, VtuData::kInline, VtuData::kAscii}) {
    for (const char* compressor :
         {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"}) {
      for (const bool big_endian : {false, true}) {
        styles.push_back({data, compressor, "UInt32", big_endian, 1000, "1.0"});
      }
    }
  }
  return styles;
}

TEST_F(MeshStreams, RowsAreReadWhateverPointsAndCellsAre) {
  VtuText mesh;
  mesh.pieces = {tet_piece(kCoordinates, kIds)};
  mesh.pieces[0].offsets.values[0] = 5;
  mesh.pieces[0].cell_data = {{"number", "Int32", {3, 4}, 1, "", "DataArray"}};
  const auto source = open(mesh);
  EXPECT_THROW(open_stream(source.get()), Error);
  const auto rows = open_rows(source.get());
  std::array<std::int32_t, 2> numbers{};
  rows->read_rows(Association::kCell, 0, 0, 2, std::as_writable_bytes(std::span(numbers)));
  EXPECT_THAT(numbers, ElementsAre(3, 4));
  CellWindow w;
  EXPECT_THROW(rows->read_cells(0, 1, &w), std::logic_error);
}

TEST_F(MeshStreams, ReadsMixedCellsOfEveryEncoding) {
  const VtuText mesh = mixed_mesh(600);
  for (const VtuStyle& style : all_styles()) {
    SCOPED_TRACE(testing::describe(style));
    const auto source = open(mesh, {}, style);
    EXPECT_TRUE(open_stream(source.get())->streams_from_disk());
  }
}

// Of points and cells alone, however they are written.
TEST_F(MeshStreams, ChecksumsTellMeshesApart) {
  const auto flags = [](const char* name) {
    std::vector<double> values(600, 0);
    values[77] = 1;
    return testing::VtuArrayText{name, "UInt8", values, 1, "", "DataArray"};
  };
  VtuText mesh = mixed_mesh(600);
  mesh.pieces[0].cell_data.push_back(flags("vtkGhostType"));
  for (const VtuStyle& style : all_styles()) {
    SCOPED_TRACE(testing::describe(style));
    const auto sum_of = [&](const VtuText& m) {
      testing::write_file(path_, to_vtu(m, style));
      return open_mesh(path_)->mesh_checksum({});
    };
    const auto sum = sum_of(mesh);
    ASSERT_TRUE(sum);
    VtuText other = mesh;
    other.pieces[0].cell_data[0].values[5] = 99;
    other.pieces[0].cell_data.push_back(flags("unknown"));
    EXPECT_EQ(sum_of(other), sum);
    other = mesh;
    other.pieces[0].coordinates.values[300] += 0.5;
    EXPECT_NE(sum_of(other), sum);
    other = mesh;
    other.pieces[0].connectivity.values[301] += 1;
    EXPECT_NE(sum_of(other), sum);
    other = mesh;
    other.pieces[0].cell_data[1].values[79] = 1;
    EXPECT_NE(sum_of(other), sum);
    other = mesh;
    other.pieces[0].cell_data[1] = flags("vtkGhostLevels");
    EXPECT_NE(sum_of(other), sum);
    other = mesh;
    other.pieces.push_back(mesh.pieces[0]);
    EXPECT_EQ(sum_of(other), std::nullopt);
  }
}

// Long enough for several chunks of every array, with windows that begin and end within them.
TEST_F(MeshStreams, ReadsWindowsAcrossChunks) {
  const VtuText mesh = mixed_mesh(60000);
  std::string text;
  for (const VtuStyle& style :
       {VtuStyle{}, VtuStyle{VtuData::kInline, "", "UInt64", true, 0, "1.0"},
        VtuStyle{VtuData::kAscii, "", "", false, 0, "1.0"},
        VtuStyle{VtuData::kAppendedRaw, "vtkLZ4DataCompressor", "UInt64", false, 4001, "1.0"},
        VtuStyle{VtuData::kInline, "vtkZLibDataCompressor", "UInt64", false, 32768, "1.0"}}) {
    SCOPED_TRACE(testing::describe(style));
    testing::write_file(path_, to_vtu(mesh, style));
    const auto source = open_mesh(path_);
    const auto stream = open_stream(source.get());
    const testing::WrittenMesh expected = testing::write_out_whole(source.get());
    for (const std::uint64_t window : {777u, 4096u, 32768u, 65537u}) {
      EXPECT_TRUE(testing::write_out_windows(*source, *stream, window) == expected) << window;
    }
  }
}

TEST_F(MeshStreams, ReadsBase64WithLineBreaksInWindows) {
  VtuText mesh = mixed_mesh(30000);
  for (const char* compressor : {"", "vtkZLibDataCompressor"}) {
    const std::string text =
        to_vtu(mesh, {VtuData::kInline, compressor, "UInt32", false, 3000, "1.0"});
    // Lines of 76 characters, as Python's encodebytes() makes them, and some blank ones.
    std::string broken;
    std::size_t column = 0;
    bool data = false;
    for (const char c : text) {
      if (c == '<') data = false;
      if (data && ++column % 76 == 0) broken += column % 988 == 0 ? "\r\n   \n" : "\n";
      broken += c;
      if (c == '>') data = true;
    }
    const auto whole = open_mesh((testing::write_file(path_, text), path_));
    const testing::WrittenMesh expected = testing::write_out_whole(whole.get());
    testing::write_file(dir_.file("broken.vtu"), broken);
    const auto source = open_mesh(dir_.file("broken.vtu"));
    const auto stream = open_stream(source.get());
    EXPECT_TRUE(stream->streams_from_disk());
    EXPECT_TRUE(testing::write_out_windows(*source, *stream, 5000) == expected);
  }
}

TEST_F(MeshStreams, SeveralThreadsReadAtOnce) {
  const VtuText mesh = mixed_mesh(20000);
  for (const char* compressor : {"", "vtkZLibDataCompressor"}) {
    testing::write_file(
        path_, to_vtu(mesh, {VtuData::kAppendedRaw, compressor, "UInt64", false, 32768, "1.0"}));
    const auto source = open_mesh(path_);
    const auto stream = open_stream(source.get());
    const testing::WrittenMesh expected = testing::write_out_whole(source.get());
    std::vector<testing::WrittenMesh> found(4);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < found.size(); ++t) {
      threads.emplace_back([&, t] {
#ifdef _OPENMP
        omp_set_num_threads(1);
#endif
        found[t] = testing::write_out_windows(*source, *stream, 1000 + 100 * t);
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const testing::WrittenMesh& mesh_found : found) EXPECT_TRUE(mesh_found == expected);
  }
}

TEST_F(MeshStreams, AFileShortenedBetweenWindowsIsAnError) {
  testing::write_file(path_, to_vtu(mixed_mesh(20000), {}));
  const auto source = open_mesh(path_);
  const auto stream = open_stream(source.get());
  CellWindow w;
  stream->read_cells(0, 1000, &w);
  std::filesystem::resize_file(path_, 50000);
  try {
    stream->read_cells(19000, 1000, &w);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code(), 4);
    EXPECT_THAT(e.what(), HasSubstr("shortened"));
  }
}

TEST_F(MeshStreams, ReadsTheRealMeshesLikeTheWhole) {
  const std::string folder = std::string(TETFUSION_TEST_DATA) + "/";
  int found = 0;
  for (const char* name : {"bluntfin", "can", "disk_out_ref", "polyfem_cubes", "pylith_crustal",
                           "quake_sf10", "spx"}) {
    const std::string path = folder + name + ".vtu";
    if (!std::ifstream(path)) continue;
    SCOPED_TRACE(path);
    ++found;
    testing::expect_windows_like_whole(path, {});
    testing::expect_windows_like_whole(path, {true, true});
  }
  if (found == 0) GTEST_SKIP() << "no " << folder;
}

}  // namespace
}  // namespace tetfusion
