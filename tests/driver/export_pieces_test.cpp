// A mesh in several files is the mesh in one file: point by point, cell by cell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <stdexcept>
#include <string>
#include <variant>

#include "driver/export/export.h"
#include "driver/export/export_pieces.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/import.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::Import;
using testing::MeshFile;
using testing::rich_box;
namespace fs = std::filesystem;

// A file, read whole: the rows of its arrays are those of the file, `mesh` may have fewer points.
struct Whole {
  explicit Whole(const std::string& path) : source(open_mesh(path)), mesh(source->read_geometry()) {
    const MeshDescription& d = source->description();
    for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
      points.push_back(source->read_array(Association::kPoint, i));
    }
    for (std::size_t i = 0; i < d.cell_data.arrays.size(); ++i) {
      cells.push_back(source->read_array(Association::kCell, i));
    }
  }
  std::string position(std::size_t point) const {
    return std::visit(
        [&](const auto& p) {
          return std::string(reinterpret_cast<const char*>(&p[point]), sizeof p[point]);
        },
        mesh.points);
  }
  static std::string row(const DataArray& array, std::uint64_t i) {
    const std::size_t bytes = array.info.components * size_of(array.info.type);
    return {reinterpret_cast<const char*>(array.bytes.data()) + i * bytes, bytes};
  }
  static std::uint64_t source_of(const Vector<std::uint64_t>& source, std::size_t i) {
    return source.empty() ? i : source[i];
  }

  std::unique_ptr<MeshSource> source;
  Geometry mesh;
  std::vector<DataArray> points, cells;
};

class ExportPieces : public ::testing::Test {
 protected:
  std::size_t files_of_pieces() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder.path() / "out_pieces"), {}));
  }
  std::string piece(std::size_t i) const {
    return folder.file("out_pieces/out_" + std::to_string(i) + ".vtu");
  }

  // The pieces, which are text, as one file with several pieces.
  std::string stitched() const {
    const std::string path = folder.file("stitched.vtu");
    std::string text, piece_text;
    for (std::size_t p = 0; p < files_of_pieces(); ++p) {
      piece_text = bytes_of(piece(p));
      const std::size_t begin = piece_text.find("    <Piece ");
      const std::size_t end = piece_text.find("  </UnstructuredGrid>");
      text += piece_text.substr(p == 0 ? 0 : begin, end - (p == 0 ? 0 : begin));
    }
    std::ofstream(path, std::ios::binary)
        << text << piece_text.substr(piece_text.find("  </Unstr"));
    return path;
  }

  // Compares the pieces, put together by our reader, with the one file.
  void expect_the_same(const std::string& ids_name) const {
    const Whole whole(one), parts(stitched());
    const MeshDescription& d = parts.source->description();
    ASSERT_EQ(parts.points.size(), whole.points.size() + 1);
    EXPECT_EQ(d.point_data.active.at("GlobalIds"), ids_name);
    const auto file_ids = parts.points.at(d.point_data.find(ids_name)).as<std::int64_t>();
    ASSERT_EQ(point_count(parts.mesh.points), point_count(whole.mesh.points));
    std::vector<std::size_t> ids;
    for (std::size_t i = 0; i < point_count(parts.mesh.points); ++i) {
      const std::uint64_t row = Whole::source_of(parts.mesh.point_source, i);
      ids.push_back(static_cast<std::size_t>(file_ids[row]));
      ASSERT_LT(ids[i], point_count(whole.mesh.points));
      ASSERT_EQ(parts.position(i) == whole.position(ids[i]), true);
      for (std::size_t a = 0; a < whole.points.size(); ++a) {
        ASSERT_EQ(Whole::row(parts.points[a], row) == Whole::row(whole.points[a], ids[i]), true);
      }
    }
    EXPECT_EQ(std::set<std::size_t>(ids.begin(), ids.end()).size(), ids.size());
    std::vector<Tet> tets(parts.mesh.tets.begin(), parts.mesh.tets.end());
    for (Tet& t : tets) {
      for (VertexId& v : t) v = static_cast<VertexId>(ids[v]);
    }
    EXPECT_TRUE(std::ranges::equal(tets, whole.mesh.tets));
    std::vector<VertexId> corners;
    for (const VertexId v : parts.mesh.lower.connectivity) {
      corners.push_back(static_cast<VertexId>(ids[v]));
    }
    EXPECT_TRUE(std::ranges::equal(corners, whole.mesh.lower.connectivity));
    EXPECT_EQ(parts.mesh.lower.types, whole.mesh.lower.types);
    EXPECT_EQ(parts.mesh.lower.offsets, whole.mesh.lower.offsets);
    for (std::size_t a = 0; a < whole.cells.size(); ++a) {
      EXPECT_TRUE(parts.cells[a].bytes == whole.cells[a].bytes);
    }
    EXPECT_EQ(d.field_data.arrays.size(), whole.source->description().field_data.arrays.size());
  }

  // No piece has a point that its cells do not use, or one twice.
  void expect_lean_pieces(std::size_t with_tets, const std::string& ids_name) const {
    for (std::size_t p = 0; p < with_tets; ++p) {
      const Whole part(piece(p));
      EXPECT_EQ(part.mesh.unused_points, 0u);
      const auto at = part.source->description().point_data.find(ids_name);
      const auto ids = part.points.at(at).as<std::int64_t>();
      EXPECT_EQ(std::set<std::int64_t>(ids.begin(), ids.end()).size(), ids.size());
    }
  }

  template <class Real = double>
  void expect_pieces(std::uint64_t chunk_tets, std::uint32_t pieces, std::size_t files,
                     const std::string& ids_name = "GlobalNodeIds") {
    SCOPED_TRACE(std::to_string(chunk_tets) + " a chunk, pieces: " + std::to_string(pieces));
    Import<Real> import(in, {.chunk_tets = chunk_tets});
    const MeshSummary expected = import.export_to(one);
    ExportSettings settings;
    settings.pieces = pieces;
    settings.threads = 2;
    settings.encoding = Encoding::kInline;
    const MeshSummary summary = import.export_to(out, settings);
    EXPECT_EQ(summary.points, expected.points);
    EXPECT_EQ(summary.tets, expected.tets);
    EXPECT_EQ(summary.boundary_triangles, expected.boundary_triangles);
    EXPECT_EQ(summary.volume, expected.volume);
    EXPECT_EQ(files_of_pieces(), files);
    expect_the_same(ids_name);
    expect_lean_pieces(files - (import.imported.lower.cells.size() > 0 ? 1 : 0), ids_name);
    fs::remove_all(folder.path() / "out_pieces");
  }

  testing::TempDir folder = testing::TempDir::in_memory();
  std::string in = folder.file("in.vtu"), one = folder.file("one.vtu"),
              out = folder.file("out.pvtu");
};

// From several chunks a piece to several pieces a chunk; the last file has the cells of lower
// dimension.
TEST_F(ExportPieces, AreTheMeshInOneFile) {
  rich_box(7).write(in);
  for (const std::uint64_t chunk_tets : {1'000'000, 400, 60}) {
    expect_pieces(chunk_tets, 0, 2);
    expect_pieces(chunk_tets, 2, 3);
    expect_pieces(chunk_tets, 7, 8);
    expect_pieces(chunk_tets, 50, 51);
  }
}

TEST_F(ExportPieces, AreTheMeshInOneFileInFloats) {
  MeshFile file = rich_box(5);
  file.geometry = testing::to_float(file.geometry);
  file.write(in);
  expect_pieces<float>(100, 4, 5);
}

TEST_F(ExportPieces, ThereAreNoMoreThanTetrahedra) {
  MeshFile file;
  file.geometry = testing::kuhn_box(2, 1, 1);
  file.write(in);
  expect_pieces(5, 40, 12);
  expect_pieces(1000, 12, 12);
}

TEST_F(ExportPieces, AnArrayThatHasTheirNameKeepsIt) {
  MeshFile file = rich_box(4);
  file.point_arrays[1].info.name = "GlobalNodeIds";
  file.point_markers["GlobalIds"] = "GlobalNodeIds";
  file.write(in);
  expect_pieces(100, 3, 4, "GlobalNodeIds_");
}

// The input's global ids say where points come from, and no more which are the same.
TEST(GlobalIdsOfPieces, TakeTheMarkOfOthers) {
  AttributeSet set;
  set.arrays = {{"ids", ValueType::kInt32, 1, {}, 0}, {"origin", ValueType::kInt32, 1, {}, 0}};
  EXPECT_EQ(with_global_ids(set).active,
            (std::map<std::string, std::string>{{"GlobalIds", "GlobalNodeIds"}}));
  set.active = {{"GlobalIds", "ids"}, {"Scalars", "ids"}};
  EXPECT_EQ(with_global_ids(set).active,
            (std::map<std::string, std::string>{
                {"GlobalIds", "GlobalNodeIds"}, {"PedigreeIds", "ids"}, {"Scalars", "ids"}}));
  set.active = {{"GlobalIds", "ids"}, {"PedigreeIds", "origin"}};
  EXPECT_EQ(with_global_ids(set).active,
            (std::map<std::string, std::string>{{"GlobalIds", "GlobalNodeIds"},
                                                {"PedigreeIds", "origin"}}));
}

TEST_F(ExportPieces, TheBytesDoNotDependOnThreadsAndScratch) {
  rich_box(8).write(in);
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kZlib, Encoding::kAscii}) {
    std::set<std::string> outputs;
    for (const bool on_disk : {false, true}) {
      Import<double> import(in, {.chunk_tets = 150, .on_disk = on_disk});
      for (const int threads : {1, 3}) {
        import.export_to(out, {"", encoding, threads, {}, 3});
        std::string all = bytes_of(out);
        for (std::size_t p = 0; p < files_of_pieces(); ++p) all += bytes_of(piece(p));
        outputs.insert(std::move(all));
        fs::remove_all(folder.path() / "out_pieces");
        fs::remove(out);
      }
      import.scratch->remove();
    }
    EXPECT_EQ(outputs.size(), 1u);
  }
}

TEST_F(ExportPieces, LeaveNothingWhereTheyFail) {
  rich_box(6).write(in);
  Import<double> import(in, {.chunk_tets = 150});
  ExportSettings settings;
  settings.pieces = 3;
  import.export_to(out, settings);
  const std::string expected = bytes_of(out), first = bytes_of(piece(0));
  double last = 0;
  for (const double when : {0.0, 0.3, 0.6, 0.99, 2.0}) {
    settings.progress = [&, when](double done) {
      EXPECT_LE(done, 1);
      last = std::max(last, done);
      if (done >= when) throw std::runtime_error("stop");
    };
    if (when > 1) break;
    EXPECT_THROW(import.export_to(folder.file("none.pvtu"), settings), std::runtime_error);
    EXPECT_THROW(import.export_to(out, settings), std::runtime_error);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 3);
    EXPECT_TRUE(bytes_of(out) == expected && bytes_of(piece(0)) == first);
  }
  import.export_to(out, settings);  // the mesh is still there
  EXPECT_EQ(last, 1);
  EXPECT_FALSE(fs::exists(folder.path() / "out_pieces"));
  EXPECT_TRUE(bytes_of(folder.file("out_pieces-2/out_0.vtu")) == first);
}

}  // namespace
}  // namespace tetfusion
