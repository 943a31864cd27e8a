#include "driver/export/export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_sink.h"
#include "io/store/scratch.h"
#include "mesh/inspection/inspect.h"
#include "support/brute_check.h"
#include "support/import.h"
#include "support/mesh_file.h"
#include "support/stream_check.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::Import;
using testing::MeshFile;
using testing::rich_box;

testing::WrittenMesh sorted(testing::WrittenMesh mesh) {
  std::ranges::sort(mesh);
  return mesh;
}

class ExportMesh : public ::testing::Test {
 protected:
  // Imports in chunks, exports, and compares with the file that it came from.
  template <class Real = double>
  void expect_the_input_again(const MeshFile& file, std::uint64_t chunk_tets) {
    SCOPED_TRACE(chunk_tets);
    file.write(in);
    Import<Real> import(in, {.chunk_tets = chunk_tets});
    const MeshSummary summary = import.export_to(out);
    const auto expected = open_mesh(in), source = open_mesh(out);
    EXPECT_TRUE(sorted(testing::write_out_whole(source.get())) ==
                sorted(testing::write_out_whole(expected.get())));
    const InputFacts& facts = import.imported.facts;
    EXPECT_EQ(summary.path, out);
    EXPECT_EQ(summary.points, facts.points);
    EXPECT_EQ(summary.tets, facts.tets);
    EXPECT_EQ(summary.boundary_triangles, facts.boundary_faces);
    EXPECT_NEAR(summary.volume, facts.volume, 1e-11 * facts.volume);
    const MeshDescription& d = source->description();
    EXPECT_EQ(d.points, summary.points);
    EXPECT_EQ(d.cells, summary.tets + file.geometry.lower.size());
    EXPECT_EQ(d.point_type, expected->description().point_type);
    EXPECT_EQ(d.point_data.active, expected->description().point_data.active);
    ASSERT_EQ(d.field_data.arrays.size(), file.field_arrays.size());
    for (std::size_t i = 0; i < file.field_arrays.size(); ++i) {
      EXPECT_EQ(source->read_array(Association::kField, i).bytes, file.field_arrays[i].bytes);
    }
    // Chunks share their points: the mesh is in one piece, and nothing is there twice.
    const Geometry g = source->read_geometry();
    EXPECT_EQ(g.unused_points, 0u);
    const auto report = testing::brute_check(g);
    EXPECT_TRUE(report.valid());
    EXPECT_EQ(report.boundary.size(), facts.boundary_faces);
    EXPECT_EQ(report.components, 1u);
  }

  testing::TempDir folder = testing::TempDir::in_memory();
  std::string in = folder.file("in.vtu"), out = folder.file("out.vtu");
};

TEST_F(ExportMesh, GivesBackWhatWasImported) {
  for (const std::uint64_t chunk_tets : {1'000'000, 1000, 150, 20}) {
    expect_the_input_again(rich_box(8), chunk_tets);
  }
}

TEST_F(ExportMesh, GivesBackFloats) {
  MeshFile file = rich_box(7);
  file.geometry = testing::to_float(file.geometry);
  file.point_arrays[3].info.component_names = {"a", "b", "c", "d", "e", "f"};
  expect_the_input_again<float>(file, 200);
  EXPECT_EQ(open_mesh(out)->description().point_data.arrays[3].component_names.at(5), "f");
}

TEST_F(ExportMesh, GivesBackAMeshWithoutArrays) {
  MeshFile file;
  file.geometry = testing::kuhn_box(5, 4, 3, 0.1);
  for (const std::uint64_t chunk_tets : {1000, 30, 3}) expect_the_input_again(file, chunk_tets);
}

TEST_F(ExportMesh, LeavesGhostMarksOut) {
  MeshFile file = rich_box(6);
  file.cell_arrays.push_back(testing::make_array<std::uint8_t>(
      "vtkGhostType", file.cells(), 1, [](auto i, auto) { return i < 100 ? 1 : 0; }));
  file.write(in);
  Import<double> import(in, {.chunk_tets = 90});
  EXPECT_EQ(import.export_to(out).tets, 980u);
  EXPECT_EQ(open_mesh(out)->description().cell_data.find("vtkGhostType"), AttributeSet::npos);
}

// The same bytes from any number of threads, from memory and from disk; and again.
TEST_F(ExportMesh, TheBytesDoNotDependOnThreadsAndScratch) {
  rich_box(8).write(in);
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kZlib, Encoding::kAscii}) {
    std::set<std::string> outputs;
    for (const bool on_disk : {false, true}) {
      Import<double> import(in, {.chunk_tets = 150, .on_disk = on_disk});
      for (const int threads : {1, 3}) {
        import.export_to(out, {"", encoding, threads, {}});
        outputs.insert(bytes_of(out));
      }
      import.scratch->remove();
    }
    EXPECT_EQ(outputs.size(), 1u);
  }
}

TEST_F(ExportMesh, LeavesNothingWhereItFails) {
  rich_box(6).write(in);
  Import<double> import(in, {.chunk_tets = 150});
  import.export_to(out);
  const std::string expected = bytes_of(out);
  ExportSettings failing;
  for (const double when : {0.0, 0.3, 0.9}) {
    failing.progress = [&](double done) {
      if (done >= when) throw std::runtime_error("stop");
    };
    EXPECT_THROW(import.export_to(folder.file("none.vtu"), failing), std::runtime_error);
    EXPECT_THROW(import.export_to(out, failing), std::runtime_error);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
  EXPECT_TRUE(bytes_of(out) == expected);
  import.export_to(out);  // the mesh is still there
  EXPECT_TRUE(bytes_of(out) == expected);
}

// Of which bytes were lost while they were used.
class LossyScratch : public Scratch {
 public:
  std::unique_ptr<PieceStore> begin(const std::string& name) override {
    return scratch_->begin(name);
  }
  void commit(const std::string&, std::span<const std::byte>) override {}
  void keep(const std::string&) override {}
  void check() const override { throw Error(ErrorCode::kIo, "bytes were lost"); }
  std::optional<Checkpoint> resume() override { return {}; }
  void drop_spares() override {}
  void remove() override {}
  std::uint64_t peak_bytes() const override { return 0; }

 private:
  std::unique_ptr<Scratch> scratch_ = memory_scratch();
};

class Room : public MeshSink {
 public:
  MeshRoom make_room(const MeshLayout& layout) override {
    points_.resize(3 * layout.points);
    corners_.resize(layout.corners);
    MeshRoom room;
    room.points = reinterpret_cast<std::byte*>(points_.data());
    room.connectivity = reinterpret_cast<std::byte*>(corners_.data());
    return room;
  }

 private:
  Vector<double> points_;
  Vector<std::int64_t> corners_;
};

TEST_F(ExportMesh, MakesNothingOfLostBytes) {
  MeshFile file;
  file.geometry = testing::kuhn_box(5, 4, 3, 0.1);
  file.write(in);
  Import<double> import(in, {.chunk_tets = 30});
  const auto kept = std::exchange(import.scratch, std::make_unique<LossyScratch>());
  Room room;
  ExportSettings to_memory;
  to_memory.sink = &room;
  EXPECT_THROW(import.export_to(out), Error);
  EXPECT_THROW(import.export_to("", to_memory), Error);
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace tetfusion
