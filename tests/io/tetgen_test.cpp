// TetGen meshes: several files to one mesh, read and written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/left_out.h"
#include "io/open_mesh.h"
#include "io/write_mesh.h"
#include "support/faulty_file_system.h"
#include "support/format_files.h"
#include "support/mesh_file.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::cell_values;
using testing::dump;
using ::testing::ElementsAre;
using testing::point_values;
using testing::replaced;

const char* const kNodes = R"(# made by hand
6 3 2 1
  1  0 0 0    1.5 -1  1
  2  1 0 0.1  2.5 -2  0   # the second
  3  0 1 0    3.5 -3  1
  4  0 0 1    4.5 -4  1
  5  1 1 -1   5.5 -5  -2
  6  9 9 9    0 0 0
)";
const char* const kTets = "2 4 1\n1 1 2 3 4 10\n2 5 2 4 3 20\n# end\n";
const char* const kFaces = "1 1\n1 2 3 4 7\n";
const char* const kEdges = "1 1\n1 1 2 -8\n";

class Tetgen : public testing::FormatTest {
 protected:
  Tetgen() { write_all(); }

  void write_all() {
    write("a.node", kNodes);
    write("a.ele", kTets);
    write("a.face", kFaces);
    write("a.edge", kEdges);
  }
  std::unique_ptr<MeshSource> open_named(const std::string& name) {
    return open_mesh(dir_.file(name));
  }
};

TEST_F(Tetgen, ReadsAllFiles) {
  for (const char* name : {"a.node", "a.ele"}) {
    const auto source = open_named(name);
    const MeshDescription& d = source->description();
    EXPECT_EQ(d.path, dir_.file(name));
    EXPECT_EQ(d.format, "TetGen mesh");
    EXPECT_EQ(d.files.size(), 3u);
    EXPECT_EQ(d.points, 6u);
    EXPECT_EQ(d.cells, 4u);
    const Geometry mesh = source->read_geometry();
    expect_sample(mesh);
    EXPECT_THAT(mesh.lower.types, ElementsAre(5, 3));
    EXPECT_THAT(mesh.lower.connectivity, ElementsAre(1, 2, 3, 0, 1));
    EXPECT_THAT(cell_values<std::int32_t>(source.get(), "tetgen:ref"), ElementsAre(10, 20, 7, -8));
    EXPECT_THAT(point_values<std::int32_t>(source.get(), "tetgen:ref"),
                ElementsAre(1, 0, 1, 1, -2, 0));
    EXPECT_THAT(point_values<double>(source.get(), "tetgen:attr2"),
                ElementsAre(-1, -2, -3, -4, -5, 0));
  }
}

TEST_F(Tetgen, NumbersMayBeginWithZero) {
  write("b.node", "5 3 0 0\n0 0 0 0\n1 1 0 0.1\n2 0 1 0\n3 0 0 1\n4 1 1 -1\n");
  write("b.ele", "2 4 0\n0 0 1 2 3\n1 4 1 3 2\n");
  const auto source = open_named("b.ele");
  EXPECT_THAT(source->read_geometry().tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{4, 1, 3, 2}));
  EXPECT_TRUE(source->description().point_data.arrays.empty());
  EXPECT_TRUE(source->description().cell_data.arrays.empty());
}

TEST_F(Tetgen, WholeNumbersMayBeWrittenInAnyWay) {
  write("a.ele", "2 4 1\n1 1 2 3 4 +10\n2 5 2 4 3 2D1\n");
  const auto source = open_named("a.node");
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "tetgen:ref"), ElementsAre(10, 20, 7, -8));
}

TEST_F(Tetgen, AttributesMayBeFractions) {
  write("a.ele", "2 4 2\n1 1 2 3 4 10 5\n2 5 2 4 3 0.5 6\n");
  const auto source = open_named("a.node");
  EXPECT_THAT(cell_values<double>(source.get(), "tetgen:ref"), ElementsAre(10, 0.5, 7, -8));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "tetgen:ref2"), ElementsAre(5, 6, 0, 0));
  EXPECT_EQ(left_out_of("c.ele", source->description()),
            "c.ele has no place for these arrays, which are left out: tetgen:ref2");
  convert(source.get(), "c.ele");
  EXPECT_EQ(bytes_of(dir_.file("c.ele")), "2 4 1\n1 1 2 3 4 10\n2 5 2 4 3 0.5\n");
  EXPECT_EQ(bytes_of(dir_.file("c.face")), kFaces);
}

TEST_F(Tetgen, WholeAttributesAreIntegersHoweverTheyAreWritten) {
  const auto type_with = [&](const std::string& first, const std::string& second) {
    write("mesh.node", "5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n");
    write("mesh.ele", "2 4 1\n1 1 2 3 4 " + first + "\n2 2 3 4 5 " + second + "\n");
    return open_named("mesh.ele")->read_array(Association::kCell, 0);
  };
  const DataArray small = type_with("1.0", "2e0");
  ASSERT_EQ(small.info.type, ValueType::kInt32);
  EXPECT_EQ(small.as<const std::int32_t>()[1], 2);
  const DataArray large = type_with("3000000000", "-3e9");
  ASSERT_EQ(large.info.type, ValueType::kInt64);
  EXPECT_EQ(large.as<const std::int64_t>()[0], 3'000'000'000);
  EXPECT_EQ(large.as<const std::int64_t>()[1], -3'000'000'000);
  EXPECT_EQ(type_with("1", "2.5").info.type, ValueType::kFloat64);
  EXPECT_EQ(type_with("1", "1e17").info.type, ValueType::kFloat64);
}

// With -o2 there are points in the middle of sides, with -nn the tetrahedra beside faces.
TEST_F(Tetgen, MoreColumns) {
  write("a.face", "1 1\n1 2 3 4 7 1 -1\n");
  const auto source = open_named("a.node");
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "tetgen:ref"), ElementsAre(10, 20, 7, -8));
  write("a.ele", "1 10 1\n1 1 2 3 4 5 6 1 2 3 4 10\n");
  write("a.face", "1 1\n1 2 3 4 5 6 1 7\n");
  write("a.edge", "1 1\n1 1 2 3 -8\n");
  const auto curved = open_mesh(dir_.file("a.ele"), {false, true});
  EXPECT_THAT(curved->read_geometry().lower.connectivity, ElementsAre(1, 2, 3, 0, 1));
  EXPECT_THAT(cell_values<std::int32_t>(curved.get(), "tetgen:ref"), ElementsAre(10, 7, -8));
  expect_error("a.ele", "1 10 1\n1 1 2 3 4 5 6 1 2 3 4 10\n", "use --linearize");
}

// With -f and -e TetGen lists every face and edge, marked where it means something.
TEST_F(Tetgen, OfListsOfAllFacesAndEdgesTheMarkedOnesAreCells) {
  write("a.face",
        "7 1\n1 1 2 3 0\n2 2 3 4 7\n3 1 3 4 0\n4 1 2 4 -1\n5 5 2 4 0\n6 5 4 3 0\n7 5 2 3 0\n");
  write("a.edge",
        "9 1\n1 1 2 -8\n2 1 3 0\n3 1 4 0\n4 2 3 0\n5 2 4 0\n6 3 4 0\n7 5 2 0\n8 5 3 0\n9 5 4 9\n");
  const auto source = open_and_compare("a.node", kNodes);
  EXPECT_EQ(source->description().cells, 6u);
  EXPECT_THAT(source->description().left_out,
              ElementsAre("5 faces with marker 0, as a.face lists all faces",
                          "7 edges with marker 0, as a.edge lists all edges"));
  const Geometry mesh = source->read_geometry();
  expect_sample(mesh);
  EXPECT_THAT(mesh.lower.types, ElementsAre(5, 5, 3, 3));
  EXPECT_THAT(mesh.lower.connectivity, ElementsAre(1, 2, 3, 0, 1, 3, 0, 1, 4, 3));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "tetgen:ref"),
              ElementsAre(10, 20, 7, -1, -8, 9));
  write("a.face", "4 0\n1 1 2 3\n2 2 3 4\n3 1 3 4\n4 1 2 4\n");
  write("a.edge", "7 1\n1 1 2 0\n2 1 3 0\n3 1 4 0\n4 2 3 0\n5 2 4 0\n6 3 4 0\n7 5 2 0\n");
  const auto unmarked = open_and_compare("a.node", kNodes);
  EXPECT_THAT(unmarked->description().left_out,
              ElementsAre("4 faces without markers, as a.face lists all faces"));
  EXPECT_THAT(unmarked->read_geometry().lower.types, ElementsAre(3, 3, 3, 3, 3, 3, 3));
  write("a.face", "4 0\n1 1 2 3\n2 2 3 4\n3 1 3 4\n4 1 2\n");
  expect_error("a.node", kNodes, "a.face: line 5: expected 4 rows of 4 numbers");
}

// More than there are between two places that are kept in mind, and between those read at a time.
TEST_F(Tetgen, MarkedFacesMayBeFarApart) {
  constexpr int kFaceRows = 300'000;
  std::string faces = std::to_string(kFaceRows) + " 1\n";
  std::vector<std::int32_t> expected = {10, 20};
  for (int i = 0; i < kFaceRows; ++i) {
    const int marker = i % 4099 == 17 || i > 299'990 ? i : 0;
    faces += std::to_string(i) + " 2 3 4 " + std::to_string(marker) + "\n";
    if (marker != 0) expected.push_back(marker);
  }
  write("a.face", faces);
  write("a.edge", "0 0\n");
  const auto source = open_and_compare("a.node", kNodes);
  const auto found = cell_values<std::int32_t>(source.get(), "tetgen:ref");
  EXPECT_EQ(std::vector<std::int32_t>(found.begin(), found.end()), expected);
  const auto stream = source->stream();
  ASSERT_NE(stream, nullptr);
  for (std::uint64_t first = 0; first < expected.size(); first += 7) {
    const std::uint64_t count = std::min<std::uint64_t>(7, expected.size() - first);
    std::vector<std::int32_t> rows(count);
    stream->read_rows(Association::kCell, 0, first, count, std::as_writable_bytes(std::span(rows)));
    for (std::uint64_t i = 0; i < count; ++i) ASSERT_EQ(rows[i], expected[first + i]) << first + i;
  }
}

TEST_F(Tetgen, SaysWhatIsWrongAndWhere) {
  expect_error("a.node", replaced(kNodes, "6 3 2 1", "6 2 2 1"), "expected points of 3 dimensions");
  expect_error("a.node", replaced(kNodes, "6 3 2 1", "7 3 2 1"),
               "line 9: expected 7 rows of 7 numbers, found 42 numbers");
  expect_error("a.node", replaced(kNodes, "3.5 -3  1", "3.5 -3"),
               "line 5: expected 6 rows of 7 numbers, found 41 numbers, 6 in this line");
  expect_error("a.node", replaced(kNodes, "6 3 2 1", "60000000000 3 2 1"), "do not fit into the");
  expect_error("a.node", replaced(kNodes, "0.1", "0,1"), "line 4: expected a number, found '0,1'");
  expect_error("a.node", replaced(kNodes, "  5  ", "  7  "),
               "line 7: point 7 stands where 5 is expected");
  write_all();
  expect_error("a.ele", replaced(kTets, "2 5 2 4 3", "2 5 2 4 9"),
               "a.ele: line 3: uses point 9, but there are points 1 to 6");
  expect_error("a.ele", replaced(kTets, "2 4 1", "2 5 1"), "expected tetrahedra of 4 or 10 points");
  expect_error("a.ele", "# nothing", "there is nothing in it");
  write_all();
  std::filesystem::remove(dir_.file("a.ele"));
  expect_error("a.node", kNodes, "a.ele: cannot open the file", 4);
}

TEST_F(Tetgen, NamesMayBeInCapitals) {
  for (const auto& [name, bytes] : {std::pair("B.NODE", kNodes), std::pair("B.ELE", kTets),
                                    std::pair("B.FACE", kFaces), std::pair("B.EDGE", kEdges)}) {
    write(name, bytes);
  }
  const std::string expected = dump(open_named("a.node").get());
  EXPECT_EQ(dump(open_named("B.NODE").get()), expected);
  EXPECT_EQ(dump(open_named("B.ELE").get()), expected);
  write_mesh(open_named("a.node").get(), dir_.file("C.NODE"), {});
  EXPECT_EQ(dump(open_named("C.ELE").get()).size(), expected.size());
}

TEST_F(Tetgen, TellsOfVertexCells) {
  write("v.mesh",
        "MeshVersionFormatted 2 Dimension 3 Vertices 4 0 0 0 1 1 0 0 1 0 1 0 1 0 0 1 1 "
        "RequiredVertices 2 1 3 Tetrahedra 1 1 2 3 4 1 End");
  std::string told;
  WriteOptions options;
  options.tell = [&](std::string_view what) { told = what; };
  write_mesh(open_mesh(dir_.file("v.mesh")).get(), dir_.file("v.node"), options);
  EXPECT_EQ(told, dir_.file("v.node") + " has no place for 2 vertex cells: left out");
}

TEST_F(Tetgen, SurvivesDamage) {
  for (const auto& [name, bytes] : {std::pair("a.node", kNodes), std::pair("a.ele", kTets),
                                    std::pair("a.face", kFaces), std::pair("a.edge", kEdges)}) {
    write_all();
    expect_no_crash(name, bytes);
  }
}

// A text may lose the last digits of its last number.
TEST_F(Tetgen, IsNeverReadByHalf) {
  expect_no_half_mesh("a.node", std::string(kNodes).substr(0, std::string(kNodes).find("  6  9")) +
                                    "  6  9 9 9    0 0 0");
  write_all();
  expect_no_half_mesh("a.ele", "2 4 1\n1 1 2 3 4 10\n2 5 2 4 3 2");
}

TEST_F(Tetgen, Writes) {
  const auto source = open_named("a.node");
  convert(source.get(), "b.ele");
  EXPECT_EQ(bytes_of(dir_.file("b.node")), R"(# attributes: tetgen:attr1, tetgen:attr2
6 3 2 1
1 0 0 0 1.5 -1 1
2 1 0 0.1 2.5 -2 0
3 0 1 0 3.5 -3 1
4 0 0 1 4.5 -4 1
5 1 1 -1 5.5 -5 -2
6 9 9 9 0 0 0
)");
  EXPECT_EQ(bytes_of(dir_.file("b.ele")), "2 4 1\n1 1 2 3 4 10\n2 5 2 4 3 20\n");
  EXPECT_EQ(bytes_of(dir_.file("b.face")), kFaces);
  EXPECT_EQ(bytes_of(dir_.file("b.edge")), kEdges);
  const auto back = open_named("b.node");
  convert(back.get(), "c.node");
  for (const char* end : {".node", ".ele", ".face", ".edge"}) {
    EXPECT_EQ(bytes_of(dir_.file(std::string("b") + end)),
              bytes_of(dir_.file(std::string("c") + end)));
  }
}

TEST_F(Tetgen, WritesOtherMeshes) {
  const testing::MeshFile box = testing::rich_box(6);
  box.write(dir_.file("box.vtu"));
  const auto source = open_named("box.vtu");
  EXPECT_EQ(left_out_of("x.ele", source->description()),
            "x.ele has no place for these arrays, which are left out: ids, rgb, stress, number, "
            "TimeValue");
  convert(source.get(), "b.node");
  const auto back = open_named("b.ele");
  const Geometry before = source->read_geometry();
  const Geometry after = back->read_geometry();
  EXPECT_EQ(before.tets, after.tets);
  const auto old_values = cell_values<std::int32_t>(source.get(), "material");
  const auto new_values = cell_values<std::int32_t>(back.get(), "tetgen:ref");
  for (std::size_t t = 0; t < before.tets.size(); ++t) ASSERT_EQ(old_values[t], new_values[t]);
}

// No old .edge may be taken for a part of the new mesh.
TEST_F(Tetgen, ReplacesAllFiles) {
  write("b.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
  write("b.ele", "1 4 0\n1 1 2 3 4\n");
  convert(open_named("b.ele").get(), "a.node");
  EXPECT_EQ(bytes_of(dir_.file("a.edge")), "0 0\n");
  EXPECT_EQ(open_named("a.ele")->read_geometry().lower.size(), 0u);
}

// Wherever the disk is full, all four are the old ones, or all are new.
TEST_F(Tetgen, IsNeverWrittenByHalf) {
  const std::vector<std::string> names{"b.node", "b.face", "b.edge", "b.ele"};
  int failed = 0;
  bool is_written = false;
  for (std::int64_t room = 0; !is_written && room < 10000; room += 16) {
    for (const std::string& name : names) write(name, "old");
    const auto source = open_named("a.node");
    {
      testing::FaultyFileSystem system;
      system.fill_up_after(room);
      try {
        convert(source.get(), "b.node");
        is_written = true;
      } catch (const Error&) {
        ++failed;
      }
    }
    for (const std::string& name : names) {
      EXPECT_EQ(bytes_of(dir_.file(name)) != "old", is_written) << name << ' ' << room;
    }
  }
  EXPECT_TRUE(is_written);
  EXPECT_GT(failed, 5);
}

}  // namespace
}  // namespace tetfusion
