// Gmsh meshes: text and binary of versions 2.2 and 4.1, read and written.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "io/gmsh/gmsh_steps.h"
#include "io/left_out.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/write_mesh.h"
#include "support/format_files.h"
#include "support/mesh_file.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::Bytes;
using testing::bytes_of;
using testing::cell_values;
using testing::dump;
using ::testing::ElementsAre;
using testing::point_values;
using testing::replaced;
using testing::values;

using Gmsh = testing::FormatTest;

const std::string kData = R"($NodeData
1
"T"
1
0.5
3
0
1
2
20 1.5
10 -2
$EndNodeData
$ElementData
2
"flux"
"scheme"
0
3
0
3
1
12 1 2 3
$EndElementData
)";

// Nodes and elements with gaps in their numbers, in no order.
const std::string kText2 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
3 9 "the body"
2 7 "inlet"
$EndPhysicalNames
$Nodes
6
10 0 0 0
20 1 0 0.1
7 0 1 0
40 0 0 1
50 1 1 -1
60 9 9 9
$EndNodes
$Periodic
0
$EndPeriodic
$Elements
5
3 2 2 7 3 20 7 40
1 15 2 0 1 7
12 4 2 9 5 10 20 7 40
11 4 4 9 6 1 2 50 20 40 7
2 1 2 0 4 10 20
$EndElements
)" + kData;

const std::string kText4 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
3 9 "the body"
2 7 "inlet"
$EndPhysicalNames
$Entities
1 1 1 2
1 0 1 0 0
4 0 0 0 1 1 1 0 2 1 -1
3 0 0 0 1 1 1 1 -7 1 4
5 0 0 0 1 1 1 1 9 1 3
6 0 0 0 1 1 1 1 9 0
$EndEntities
$Nodes
2 6 7 60
3 5 0 2
10
20
0 0 0
1 0 0.1
2 3 1 4
7
40
50
60
0 1 0 0.25 0.5
0 0 1 0.25 0.5
1 1 -1 0 0
9 9 9 0 0
$EndNodes
$Periodic
0
$EndPeriodic
$Elements
5 5 1 12
2 3 2 1
3 20 7 40
0 1 15 1
1 7
3 5 4 1
12 10 20 7 40
3 6 4 1
11 50 20 40 7
1 4 1 1
2 10 20
$EndElements
)" + kData;

TEST_F(Gmsh, ReadsText) {
  const auto source = open_and_compare("a.msh", kText2);
  const MeshDescription& d = source->description();
  EXPECT_EQ(d.format, "Gmsh mesh, 2.2, text");
  EXPECT_THAT(d.left_out, ElementsAre("Periodic", "numbers of partitions"));
  EXPECT_EQ(d.points, 6u);
  EXPECT_EQ(d.cells, 5u);
  const Geometry mesh = source->read_geometry();
  expect_sample(mesh);
  EXPECT_THAT(mesh.lower.types, ElementsAre(5, 1, 3));
  EXPECT_THAT(mesh.lower.connectivity, ElementsAre(1, 2, 3, 2, 0, 1));
  EXPECT_THAT(mesh.tet_source, ElementsAre(2, 3));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:physical"), ElementsAre(7, 0, 9, 9, 0));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:geometrical"),
              ElementsAre(3, 1, 5, 6, 4));
  const auto t = point_values<double>(source.get(), "T");
  EXPECT_EQ(t[0], -2);
  EXPECT_EQ(t[1], 1.5);
  EXPECT_TRUE(std::isnan(t[2]));
  const auto flux = cell_values<double>(source.get(), "flux");
  EXPECT_EQ(flux.size(), 15u);
  EXPECT_EQ(flux[7], 2);
  EXPECT_TRUE(std::isnan(flux[0]));
  ASSERT_EQ(d.field_data.arrays.size(), 3u);
  EXPECT_EQ(d.field_data.arrays[2].name, "TimeValue");
  EXPECT_THAT(values<double>(source->read_array(Association::kField, 2)), ElementsAre(0.5));
  EXPECT_EQ(d.field_data.arrays[0].name, "gmsh:physical:the body");
  EXPECT_THAT(values<std::int32_t>(source->read_array(Association::kField, 0)), ElementsAre(9, 3));
}

TEST_F(Gmsh, ArraysComeInAnyOrder) {
  const auto source = open_and_compare("a.msh", kText4);
  const auto flux = cell_values<double>(source.get(), "flux");
  const auto tags = cell_values<std::int32_t>(source.get(), "gmsh:physical");
  EXPECT_EQ(flux[8], 3);
  EXPECT_THAT(tags, ElementsAre(7, 0, 9, 9, 0));
  EXPECT_EQ(dump(source.get()), dump(open_and_compare("b.msh", kText4).get()));
  EXPECT_EQ(dump(source.get()), dump(source.get()));
}

TEST_F(Gmsh, BothVersionsMeanTheSame) {
  EXPECT_EQ(dump(open_and_compare("a.msh", kText2).get()),
            dump(open_and_compare("b.msh", kText4).get()));
  EXPECT_EQ(open("a", kText4)->description().format, "Gmsh mesh, 4.1, text");
}

void put_data(const char* head, const char* section, int number, const std::vector<double>& row,
              Bytes* out) {
  out->text(head).put(std::int32_t{number}).put_all(row);
  out->text("\n$End").text(section).text("\n");
}

void put_all_data(Bytes* out) {
  out->text("$NodeData\n1\n\"T\"\n1\n0.5\n3\n0\n1\n2\n");
  out->put(std::int32_t{20}).put(1.5);
  put_data("", "NodeData", 10, {-2}, out);
  put_data("$ElementData\n2\n\"flux\"\n\"scheme\"\n0\n3\n0\n3\n1\n", "ElementData", 12, {1, 2, 3},
           out);
}

const std::vector<int> kNumbers = {10, 20, 7, 40, 50, 60};
const std::vector<std::vector<double>> kPoints = {{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0},
                                                  {0, 0, 1}, {1, 1, -1},  {9, 9, 9}};

Bytes binary_head(const char* version, bool swapped) {
  Bytes out(swapped);
  out.text("$MeshFormat\n").text(version).text(" 1 8\n").put(std::int32_t{1});
  out.text("\n$EndMeshFormat\n$PhysicalNames\n2\n3 9 \"the body\"\n2 7 \"inlet\"\n");
  return out.text("$EndPhysicalNames\n");
}

std::string binary2(bool swapped) {
  Bytes out = binary_head("2.2", swapped);
  out.text("$Nodes\n6\n");
  for (std::size_t i = 0; i < 6; ++i) out.put(kNumbers[i]).put_all(kPoints[i]);
  out.text("\n$EndNodes\n$Periodic\n0\n$EndPeriodic\n$Elements\n5\n");
  out.put_all(std::vector<int>{2, 1, 2, 3, 7, 3, 20, 7, 40});
  out.put_all(std::vector<int>{15, 1, 2, 1, 0, 1, 7});
  out.put_all(std::vector<int>{4, 2, 2, 12, 9, 5, 10, 20, 7, 40, 11, 9, 6, 50, 20, 40, 7});
  out.put_all(std::vector<int>{1, 1, 2, 2, 0, 4, 10, 20});
  out.text("\n$EndElements\n");
  put_all_data(&out);
  return out.str();
}

std::string binary4(bool swapped) {
  using Sizes = std::vector<std::uint64_t>;
  using Ints = std::vector<std::int32_t>;
  const std::vector<double> box = {0, 0, 0, 1, 1, 1};
  Bytes out = binary_head("4.1", swapped);
  out.text("$Entities\n").put_all(Sizes{1, 1, 1, 2});
  out.put(1).put_all(std::vector<double>{0, 1, 0}).put_all(Sizes{0});
  out.put(4).put_all(box).put_all(Sizes{0, 2}).put_all(Ints{1, -1});
  out.put(3).put_all(box).put_all(Sizes{1}).put(-7).put_all(Sizes{1}).put(4);
  out.put(5).put_all(box).put_all(Sizes{1}).put(9).put_all(Sizes{1}).put(3);
  out.put(6).put_all(box).put_all(Sizes{1}).put(9).put_all(Sizes{0});
  out.text("\n$EndEntities\n$Nodes\n").put_all(Sizes{2, 6, 7, 60});
  out.put_all(Ints{3, 5, 0}).put_all(Sizes{2, 10, 20}).put_all(kPoints[0]).put_all(kPoints[1]);
  out.put_all(Ints{2, 3, 1}).put_all(Sizes{4, 7, 40, 50, 60});
  for (std::size_t i = 2; i < 6; ++i) out.put_all(kPoints[i]).put(0.25).put(0.5);
  out.text("\n$EndNodes\n$Periodic\n0\n$EndPeriodic\n$Elements\n").put_all(Sizes{5, 5, 1, 12});
  out.put_all(Ints{2, 3, 2}).put_all(Sizes{1, 3, 20, 7, 40});
  out.put_all(Ints{0, 1, 15}).put_all(Sizes{1, 1, 7});
  out.put_all(Ints{3, 5, 4}).put_all(Sizes{1, 12, 10, 20, 7, 40});
  out.put_all(Ints{3, 6, 4}).put_all(Sizes{1, 11, 50, 20, 40, 7});
  out.put_all(Ints{1, 4, 1}).put_all(Sizes{1, 2, 10, 20});
  out.text("\n$EndElements\n");
  put_all_data(&out);
  return out.str();
}

TEST_F(Gmsh, ReadsBinary) {
  const std::string expected = dump(open_and_compare("a.msh", kText2).get());
  for (const bool swapped : {false, true}) {
    EXPECT_EQ(dump(open_and_compare("a.msh", binary2(swapped)).get()), expected) << swapped;
    EXPECT_EQ(dump(open_and_compare("a.msh", binary4(swapped)).get()), expected) << swapped;
  }
  EXPECT_EQ(open("a.msh", binary4(true))->description().format, "Gmsh mesh, 4.1, binary");
}

// The end of a section may well stand among its numbers.
TEST_F(Gmsh, NumbersMayLookLikeAnEnd) {
  std::string bytes = binary2(false);
  const std::string end = "$EndNodes\n$Nodes\n6\n$End";
  const std::size_t first = bytes.find("$Nodes\n6\n") + 9;
  std::copy(end.begin(), end.end(), bytes.begin() + static_cast<std::ptrdiff_t>(first) + 4);
  EXPECT_EQ(open_and_compare("a.msh", bytes)->read_geometry().tets.size(), 2u);
}

TEST_F(Gmsh, OtherCellsNeedAnOption) {
  const std::string head =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n"
      "5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n$Elements\n";
  const std::string cube = head + "1\n1 5 2 1 1 1 2 3 4 5 6 7 8\n$EndElements\n";
  expect_error("a.msh", cube, "cell 0 is a hexahedron (VTK cell type 12): use --tetrahedralize");
  EXPECT_EQ(open_and_compare("a.msh", cube, {true, false})->read_geometry().tets.size(), 6u);
  const std::string prisms =
      head + "2\n1 6 2 1 1 1 2 4 5 6 8\n2 6 2 1 1 2 3 4 6 7 8\n$EndElements\n";
  const Geometry mesh = open_and_compare("a.msh", prisms, {true, false})->read_geometry();
  EXPECT_EQ(mesh.tets.size(), 6u);
  const std::string curved = head + "1\n1 11 2 1 1 1 2 4 5 6 7 8 3 1 2\n$EndElements\n";
  expect_error("a.msh", curved, "use --linearize");
  EXPECT_THAT(open_and_compare("a.msh", curved, {false, true})->read_geometry().tets,
              ElementsAre(Tet{0, 1, 2, 3}));
  expect_error("a.msh", head + "1\n1 999 2 1 1 1 2\n$EndElements\n",
               "line 17: elements of Gmsh's type 999 cannot be read");
}

// The corners come first, whatever the order.
TEST_F(Gmsh, CellsOfHigherOrderAreLinearized) {
  std::string nodes = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n27\n";
  std::string ids;
  for (int n = 1; n <= 27; ++n) {
    const int corner = n - 1;
    const int x = corner % 4 == 1 || corner % 4 == 2 ? 1 : 0;
    nodes += n <= 8 ? fmt::format("{} {} {} {}\n", n, x, corner % 4 / 2, corner / 4)
                    : fmt::format("{} 0.5 0.5 {}\n", n, 0.01 * n);
  }
  const auto file = [&](int type, int count) {
    std::string text = nodes + fmt::format("$EndNodes\n$Elements\n1\n1 {} 2 1 1", type);
    for (int n = 1; n <= count; ++n) text += fmt::format(" {}", n);
    return text + "\n$EndElements\n";
  };
  const OpenOptions kBoth = {.tetrahedralize = true, .linearize = true};
  const Geometry cube = open_and_compare("a.msh", file(5, 8), kBoth)->read_geometry();
  for (const auto& [type, count] : {std::pair{17, 20}, std::pair{12, 27}}) {
    SCOPED_TRACE(type);
    const Geometry mesh = open_and_compare("a.msh", file(type, count), kBoth)->read_geometry();
    EXPECT_EQ(mesh.tets, cube.tets);
    EXPECT_EQ(mesh.unused_points, 19u);
    expect_error("a.msh", file(type, count), "use --linearize and --tetrahedralize", 3,
                 {.tetrahedralize = true});
    expect_error("a.msh", file(type, count), "use --linearize and --tetrahedralize", 3,
                 {.tetrahedralize = false, .linearize = true});
  }
  const Geometry cubic = open_and_compare("a.msh", file(29, 20), kBoth)->read_geometry();
  EXPECT_THAT(cubic.tets, ElementsAre(Tet{0, 1, 2, 3}));
  expect_error("a.msh", file(29, 20), "is a Lagrange tetrahedron (VTK cell type 71): use --linear");
  // Node 28 is none of the corners, but too few nodes are an error.
  expect_error("a.msh", file(29, 19), "line", 3, kBoth);
}

TEST_F(Gmsh, SaysWhatIsWrongAndWhere) {
  expect_error("a.msh", replaced(kText2, "2.2 0", "1 0"),
               "a Gmsh file of version '1', expected 2.2");
  expect_error("a.msh", replaced(kText2, "2.2 0 8", "2.2 0 4"), "expected 0 or 1 and 8");
  expect_error("a.msh", replaced(kText2, "7 0 1 0", "7 0 1x 0"),
               "line 13: expected a number, found '1x'");
  expect_error("a.msh", replaced(kText2, "7 0 1 0", "10 0 1 0"), "node 10 is there twice");
  expect_error("a.msh", replaced(kText2, "50 20 40 7", "51 20 40 7"),
               "line 26: element 11 uses node 51, which is not there");
  expect_error("a.msh", replaced(kText2, "$Nodes\n6", "$Nodes\n6666666"),
               "line 10: 6666666 rows do not fit into the");
  expect_error("a.msh", replaced(kText2, "$Nodes\n6", "$Nodes\n7"), "the section ends too early");
  expect_error("a.msh", replaced(kText2, "$Nodes\n6", "$Nodes\n5"), "expected the section's end");
  expect_error("a.msh", replaced(kText2, "$EndNodes", "$EndModes"),
               "line 9: $Nodes: there is no $EndNodes");
  expect_error("a.msh", replaced(kText2, "12 1 2 3", "13 1 2 3"),
               "line 50: \"flux\" has a value for 13, which is not there");
  expect_error("a.msh", replaced(kText2, "60 9 9 9", "60 9 9 9 9"), "expected the section's end");
  expect_error("a.msh", replaced(kText4, "2 6 7 60", "2 7 7 60"), "expected 7 nodes, found 6");
  expect_error("a.msh", replaced(kText4, "5 5 1 12", "5 4 1 12"),
               "more elements than the 4 announced");
  expect_error("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "there are no $Nodes");
  expect_error("a.msh", "hello", "expected a section");
  expect_error("a.msh", "(1 \"a grid\")\n", "This is a Fluent mesh, it seems");
  expect_error("a.msh", "MESH dimension 3 ElemType Tetrahedra Nnode 4\n", "a mesh of GiD");
  expect_error("a.msh", " 726 1287 163\n 0.5 1 0\n", "let it save a .mesh");
  expect_error("a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n", "there are no $Elements");
}

TEST_F(Gmsh, CommentsMayComeFirst) {
  const std::string comment = "$Comments\nby hand\n$EndComments\n";
  EXPECT_EQ(dump(open("a.msh", comment + kText2).get()), dump(open("b.msh", kText2).get()));
}

TEST_F(Gmsh, SurvivesDamage) {
  for (const std::string& bytes : {kText2, kText4}) {
    expect_no_crash("a.msh", bytes);
  }
  for (const std::string& bytes : {binary2(false), binary4(true)}) expect_no_crash("a.msh", bytes);
}

// Arrays come last: without them a file is whole.
TEST_F(Gmsh, IsNeverReadByHalf) {
  for (std::string bytes : {kText2, kText4, binary2(true), binary4(false)}) {
    bytes.resize(bytes.find("$EndElements") + 13);
    expect_no_half_mesh("a.msh", bytes);
  }
}

TEST_F(Gmsh, WritesText) {
  const auto source = open_and_compare("a.msh", kText2);
  WriteOptions options;
  options.encoding = Encoding::kAscii;
  write_mesh(source.get(), dir_.file("b.msh"), options);
  EXPECT_EQ(bytes_of(dir_.file("b.msh")), R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
3 9 "the body"
2 7 "inlet"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0.1
3 0 1 0
4 0 0 1
5 1 1 -1
$EndNodes
$Elements
5
1 4 2 9 5 1 2 3 4
2 4 2 9 6 5 2 4 3
3 2 2 7 3 2 3 4
4 15 2 0 1 3
5 1 2 0 4 1 2
$EndElements
$NodeData
1
"T"
1
0.5
3
0
1
2
1 -2
2 1.5
$EndNodeData
$ElementData
1
"flux"
1
0.5
3
0
3
1
1 1 2 3
$EndElementData
)");
}

// What has no number at all is missing, as it is read; what has some is there.
TEST_F(Gmsh, RowsWithoutNumbersAreNotWritten) {
  std::string text = kText2;
  const std::string some = "1\n12 1 2 3\n";
  text.replace(text.find(some), some.size(), "3\n12 1 nan 3\n3 nan nan nan\n2 4 5 6\n");
  const std::string none = "$NodeData\n1\n\"none\"\n0\n3\n0\n1\n1\n7 nan\n$EndNodeData\n";
  const auto source = open("a.msh", text + none);
  const auto flux = cell_values<double>(source.get(), "flux");
  for (const Encoding encoding : {Encoding::kAscii, Encoding::kRaw}) {
    WriteOptions options;
    options.encoding = encoding;
    write_mesh(source.get(), dir_.file("b.msh"), options);
    const std::string bytes = bytes_of(dir_.file("b.msh"));
    EXPECT_NE(bytes.find("\"flux\"\n1\n0.5\n3\n0\n3\n2\n"), std::string::npos);
    EXPECT_NE(bytes.find("\"none\"\n1\n0.5\n3\n0\n1\n0\n"), std::string::npos);
    const auto back = open_and_compare("c.msh", bytes);
    ASSERT_NE(back->stream(), nullptr);
    const auto again = cell_values<double>(back.get(), "flux");
    const std::vector<std::size_t> order = {2, 3, 0, 1, 4};  // tetrahedra come first
    for (std::size_t i = 0; i < flux.size(); ++i) {
      const double before = flux[3 * order[i / 3] + i % 3];
      EXPECT_TRUE(again[i] == before || (std::isnan(again[i]) && std::isnan(before))) << i;
    }
    for (const double value : point_values<double>(back.get(), "none")) {
      EXPECT_TRUE(std::isnan(value));
    }
  }
}

// Of several times nobody knows which is the mesh's, and 0 is what is written where there is none.
TEST_F(Gmsh, OneTimeIsTheMeshs) {
  for (const auto& [time, known] : {std::pair("0", false), {"nan", false}, {"-2e-3", true}}) {
    std::string text = kText2;
    text.replace(text.find("0.5"), 3, time);
    EXPECT_EQ(open("t.msh", text)->description().field_data.find("TimeValue") != AttributeSet::npos,
              known)
        << time;
  }
  std::string second = kData.substr(0, kData.find("$ElementData"));
  second.replace(second.find("0.5"), 3, "0.75");
  const auto two = open("two.msh", kText2 + second);
  EXPECT_EQ(two->description().point_data.arrays.size(), 2u);
  EXPECT_EQ(two->description().field_data.find("TimeValue"), AttributeSet::npos);
}

// A view of several steps: its arrays say when, and are one view again in a Gmsh file.
TEST_F(Gmsh, StepsOfAViewKeepTheirTimes) {
  std::string later = kData.substr(0, kData.find("$ElementData"));
  later.replace(later.find("0.5"), 3, "0.75");
  const auto source = open("steps.msh", kText2 + later + later);
  const auto& arrays = source->description().point_data.arrays;
  ASSERT_EQ(arrays.size(), 3u);
  EXPECT_EQ(arrays[0].name, "T at 0.5");
  EXPECT_EQ(arrays[1].name, "T at 0.75");
  EXPECT_EQ(arrays[2].name, "T at 0.75 2");
  for (const Encoding encoding : {Encoding::kAscii, Encoding::kRaw}) {
    WriteOptions options;
    options.encoding = encoding;
    write_mesh(source.get(), dir_.file("back.msh"), options);
    const std::string bytes = bytes_of(dir_.file("back.msh"));
    EXPECT_NE(bytes.find("\"T\"\n1\n0.5\n3\n0\n1\n"), std::string::npos);
    EXPECT_NE(bytes.find("\"T\"\n1\n0.75\n3\n1\n1\n"), std::string::npos);
    EXPECT_NE(bytes.find("\"T at 0.75 2\"\n1\n0\n"), std::string::npos);
    const auto back = open_mesh(dir_.file("back.msh"));
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      EXPECT_EQ(back->description().point_data.arrays[i].name, arrays[i].name);
    }
  }
}

// Steps say their time in their names: what the mesh's time is, the other data say.
TEST_F(Gmsh, StepsLeaveTheTimeToTheOthers) {
  const std::string earlier = kData.substr(0, kData.find("$ElementData"));
  std::string later = earlier;
  later.replace(later.find("0.5"), 3, "0.75");
  std::string other = earlier;
  other.replace(other.find("\"T\""), 3, "\"P\"");
  const auto source = open("steps.msh", kText2 + later + other);
  ASSERT_NE(source->description().field_data.find("TimeValue"), AttributeSet::npos);
  WriteOptions text;
  text.encoding = Encoding::kAscii;
  write_mesh(source.get(), dir_.file("back.msh"), text);
  const std::string bytes = bytes_of(dir_.file("back.msh"));
  for (const char* head : {"\"T\"\n1\n0.5\n", "\"T\"\n1\n0.75\n", "\"P\"\n1\n0.5\n"}) {
    EXPECT_NE(bytes.find(head), std::string::npos) << head;
  }
}

// A mesh has one time alone.
TEST_F(Gmsh, TellsOfTimesThatDiffer) {
  std::string other = kData.substr(0, kData.find("$ElementData"));
  other.replace(other.find("\"T\"\n1\n0.5"), 9, "\"P\"\n1\n0.75");
  const auto source = open("two.msh", kText2 + other);
  EXPECT_EQ(source->description().field_data.find("TimeValue"), AttributeSet::npos);
  EXPECT_THAT(source->description().left_out,
              ElementsAre("Periodic", "numbers of partitions", "the different times of T, P"));
}

// What only looks like a step stays what it is.
TEST_F(Gmsh, OneArrayIsNoStep) {
  AttributeSet set;
  for (const char* name : {"T at 1", "U at 1", "U at 2e3", "U at noon", " at 3", "V"}) {
    set.arrays.push_back({name, ValueType::kFloat64, 1, {}, 1});
  }
  const std::vector<GmshStep> steps = gmsh_steps_of(set, 7);
  const std::vector<std::tuple<std::string, double, std::uint64_t>> expected = {
      {"T at 1", 7, 0},    {"U", 1, 0},     {"U", 2e3, 1},
      {"U at noon", 7, 0}, {" at 3", 7, 0}, {"V", 7, 0}};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(std::tuple(steps[i].name, steps[i].time, steps[i].number), expected[i]);
  }
}

TEST_F(Gmsh, TellsOfNamesThatItCannotHave) {
  MeshDescription mesh = open("a.msh", kText2)->description();
  const std::string parts =
      mesh.path + " has parts that are not read, and left out: Periodic, numbers of partitions";
  EXPECT_EQ(left_out_of("x.msh", mesh), parts);
  EXPECT_EQ(left_out_of("x.vtu", mesh), parts);
  mesh.point_data.arrays[0].name = "a\"b";
  mesh.cell_data.arrays.push_back(mesh.cell_data.arrays.back());
  mesh.cell_data.arrays.back().name = "";
  EXPECT_EQ(left_out_of("x.msh", mesh),
            parts + "; x.msh cannot have these names, and gives the arrays others: a\"b, (none)");
}

TEST_F(Gmsh, WritesWhatItReads) {
  const auto source = open_and_compare("a.msh", binary4(true));
  convert(source.get(), "b.msh");
  WriteOptions text;
  text.encoding = Encoding::kAscii;
  write_mesh(source.get(), dir_.file("c.msh"), text);
  const auto back = open_mesh(dir_.file("b.msh"));
  EXPECT_EQ(back->description().format, "Gmsh mesh, 2.2, binary");
  EXPECT_NE(back->description().field_data.find("TimeValue"), AttributeSet::npos);
  EXPECT_EQ(dump(back.get()), dump(open_mesh(dir_.file("c.msh")).get()));
  convert(back.get(), "d.msh");
  EXPECT_EQ(bytes_of(dir_.file("d.msh")), bytes_of(dir_.file("b.msh")));
  EXPECT_EQ(source->read_geometry().tets, back->read_geometry().tets);
}

TEST_F(Gmsh, KeepsAllArrays) {
  const testing::MeshFile box = testing::rich_box(6);
  box.write(dir_.file("box.vtu"));
  const auto source = open_mesh(dir_.file("box.vtu"));
  EXPECT_EQ(
      left_out_of("x.msh", source->description()),
      "x.msh has doubles for these integers, which are rounded from 2^53 on: ids; Gmsh itself "
      "shows arrays of 1, 3 or 9 components; x.msh has these as they are: tensor");
  convert(source.get(), "b.msh");
  const auto back = open_mesh(dir_.file("b.msh"));
  const Geometry before = source->read_geometry();
  const Geometry after = back->read_geometry();
  EXPECT_EQ(before.tets, after.tets);
  EXPECT_EQ(before.lower.types, after.lower.types);
  EXPECT_EQ(before.lower.connectivity, after.lower.connectivity);
  EXPECT_EQ(testing::coordinates<double>(before), testing::coordinates<double>(after));
  const auto materials = cell_values<std::int32_t>(source.get(), "material");
  EXPECT_EQ(cell_values<std::int32_t>(back.get(), "gmsh:physical"), materials);
  EXPECT_EQ(cell_values<std::int32_t>(back.get(), "gmsh:geometrical"), materials);
  EXPECT_EQ(cell_values<double>(back.get(), "stress"), cell_values<double>(source.get(), "stress"));
  const auto tensor = point_values<double>(source.get(), "tensor");
  const auto again = point_values<double>(back.get(), "tensor");
  for (std::size_t v = 0; v < testing::coordinates<double>(before).size() / 3; ++v) {
    const std::uint64_t row = before.point_source.empty() ? v : before.point_source[v];
    const std::uint64_t other = after.point_source.empty() ? v : after.point_source[v];
    ASSERT_EQ(tensor[6 * row + 5], again[6 * other + 5]);
  }
}

}  // namespace
}  // namespace tetfusion
