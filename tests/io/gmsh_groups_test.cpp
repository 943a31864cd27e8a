// Gmsh meshes: groups and their names, and partitioned meshes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

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
using testing::values;

using GmshGroups = testing::FormatTest;

// Volume 5 (group 9) was cut into 11 and 12; 12 says no group. Surface 21 and line 22 are where it
// was cut, and have the volume's group. Surface 3 (group 7) has one part, 13.
const std::string kParts = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$Entities
0 0 1 1
3 0 0 0 1 1 1 1 -7 1 4
5 0 0 0 1 1 1 1 9 1 3
$EndEntities
$PartitionedEntities
2
2
31 1
32 2
1 1 2 2
41 3 5 2 1 2 0 1 0 0
22 3 5 2 1 2 0 0 0 1 1 1 1 9 0
13 2 3 1 1 0 0 0 1 1 1 0 1 22
21 3 5 2 1 2 0 0 0 1 1 1 1 9 1 -22
11 3 5 1 1 0 0 0 1 1 1 1 9 2 13 21
12 3 5 1 2 0 0 0 1 1 1 0 1 -21
$EndPartitionedEntities
$Nodes
1 5 1 5
3 11 0 5
1
2
3
4
5
0 0 0
1 0 0.1
0 1 0
0 0 1
1 1 -1
$EndNodes
$Elements
5 5 1 12
1 22 1 1
1 2 3
2 13 2 1
3 1 2 3
2 21 2 1
2 2 3 4
3 11 4 1
12 1 2 3 4
3 12 4 1
11 5 2 4 3
$EndElements
$GhostElements
1
12 1 1 2
$EndGhostElements
)";

std::string binary_parts(bool swapped) {
  using Sizes = std::vector<std::uint64_t>;
  using Ints = std::vector<std::int32_t>;
  const std::vector<double> box = {0, 0, 0, 1, 1, 1};
  Bytes out(swapped);
  out.text("$MeshFormat\n4.1 1 8\n").put(std::int32_t{1}).text("\n$EndMeshFormat\n$Entities\n");
  out.put_all(Sizes{0, 0, 1, 1});
  out.put(3).put_all(box).put_all(Sizes{1}).put(-7).put_all(Sizes{1}).put(4);
  out.put(5).put_all(box).put_all(Sizes{1}).put(9).put_all(Sizes{1}).put(3);
  out.text("\n$EndEntities\n$PartitionedEntities\n");
  out.put_all(Sizes{2, 2}).put_all(Ints{31, 1, 32, 2}).put_all(Sizes{1, 1, 2, 2});
  const auto put_part = [&](const Ints& who, const Ints& partitions, const std::vector<double>& at,
                            const Ints& groups) {
    out.put_all(who).put(partitions.size()).put_all(partitions).put_all(at);
    out.put(groups.size()).put_all(groups);
  };
  put_part({41, 3, 5}, {1, 2}, {0, 1, 0}, {});
  put_part({22, 3, 5}, {1, 2}, box, {9});
  out.put_all(Sizes{0});
  put_part({13, 2, 3}, {1}, box, {});
  out.put_all(Sizes{1}).put(22);
  put_part({21, 3, 5}, {1, 2}, box, {9});
  out.put_all(Sizes{1}).put(-22);
  put_part({11, 3, 5}, {1}, box, {9});
  out.put_all(Sizes{2}).put_all(Ints{13, 21});
  put_part({12, 3, 5}, {2}, box, {});
  out.put_all(Sizes{1}).put(-21).text("\n$EndPartitionedEntities\n$Nodes\n");
  out.put_all(Sizes{1, 5, 1, 5}).put_all(Ints{3, 11, 0}).put_all(Sizes{5, 1, 2, 3, 4, 5});
  out.put_all(std::vector<double>{0, 0, 0, 1, 0, 0.1, 0, 1, 0, 0, 0, 1, 1, 1, -1});
  out.text("\n$EndNodes\n$Elements\n").put_all(Sizes{5, 5, 1, 12});
  out.put_all(Ints{1, 22, 1}).put_all(Sizes{1, 1, 2, 3});
  out.put_all(Ints{2, 13, 2}).put_all(Sizes{1, 3, 1, 2, 3});
  out.put_all(Ints{2, 21, 2}).put_all(Sizes{1, 2, 2, 3, 4});
  out.put_all(Ints{3, 11, 4}).put_all(Sizes{1, 12, 1, 2, 3, 4});
  out.put_all(Ints{3, 12, 4}).put_all(Sizes{1, 11, 5, 2, 4, 3});
  out.text("\n$EndElements\n$GhostElements\n").put_all(Sizes{1}).put_all(Ints{12, 1});
  out.put_all(Sizes{1}).put(2).text("\n$EndGhostElements\n");
  return out.str();
}

TEST_F(GmshGroups, PartsOfAnEntityArePutTogether) {
  const auto source = open_and_compare("a.msh", kParts);
  EXPECT_THAT(source->description().left_out,
              ElementsAre("numbers of partitions", "GhostElements", "elements between partitions"));
  EXPECT_EQ(source->description().cells, 3u);
  const Geometry mesh = source->read_geometry();
  expect_sample(mesh);
  EXPECT_THAT(mesh.lower.types, ElementsAre(5));
  EXPECT_THAT(mesh.lower.connectivity, ElementsAre(0, 1, 2));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:physical"), ElementsAre(7, 9, 9));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:geometrical"), ElementsAre(3, 5, 5));
  for (const bool swapped : {false, true}) {
    EXPECT_EQ(dump(open_and_compare("b.msh", binary_parts(swapped)).get()), dump(source.get()));
  }
}

// Version 4.0 has a box around a point, and other heads of sections and blocks.
TEST_F(GmshGroups, PartsOfVersion40ArePutTogether) {
  std::string text = kParts;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("4.1 0 8", "4 0 8");
  replace("41 3 5 2 1 2 0 1 0 0", "41 3 5 2 1 2 0 1 0 0 1 0 0");
  replace("1 5 1 5\n3 11 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0.1\n0 1 0\n0 0 1\n1 1 -1\n",
          "1 5\n11 3 0 5\n1 0 0 0\n2 1 0 0.1\n3 0 1 0\n4 0 0 1\n5 1 1 -1\n");
  replace("5 5 1 12\n", "5 5\n");
  replace("\n1 22 1 1", "\n22 1 1 1");
  replace("\n2 13 2", "\n13 2 2");
  replace("\n2 21 2", "\n21 2 2");
  replace("\n3 11 4", "\n11 3 4");
  replace("\n3 12 4", "\n12 3 4");
  const auto source = open_and_compare("a.msh", text);
  const auto expected = open("b.msh", kParts);
  EXPECT_EQ(source->description().format, "Gmsh mesh, 4.0, text");
  EXPECT_EQ(source->description().left_out, expected->description().left_out);
  EXPECT_EQ(dump(source.get()), dump(expected.get()));
  expect_no_crash("a.msh", text);
}

TEST_F(GmshGroups, APartMayHaveTheNumberOfTheWhole) {
  std::string same = kParts;
  same.replace(same.find("12 3 5 1 2"), 2, "5");
  same.replace(same.find("3 12 4 1"), 4, "3 5");
  EXPECT_EQ(dump(open_and_compare("b.msh", same).get()), dump(open("a.msh", kParts).get()));
}

TEST_F(GmshGroups, DamagedPartsAreNoCrash) {
  expect_no_crash("a.msh", kParts);
  expect_no_crash("a.msh", binary_parts(false));
  std::string more = kParts;
  more.replace(more.find("5 5 1 12"), 8, "5 1 1 12");
  expect_error("a.msh", more, "there are more elements than the 1 announced");
}

// Two tetrahedra, each in a group of its own and in that of both; a triangle in a group of one
// name and in one that has none.
const std::string kSeveral = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
2 4 "skin"
3 1 "all"
3 2 "left"
3 3 "right"
$EndPhysicalNames
$Entities
0 0 2 3
3 0 0 0 1 1 1 2 -7 4 1 4
4 0 0 0 1 1 1 1 7 0
5 0 0 0 1 1 1 2 1 2 0
6 0 0 0 1 1 1 2 1 -3 0
7 0 0 0 1 1 1 2 2 3 0
$EndEntities
$Nodes
1 5 1 5
3 5 0 5
1
2
3
4
5
0 0 0
1 0 0.1
0 1 0
0 0 1
1 1 -1
$EndNodes
$Elements
4 4 1 4
2 3 2 1
1 2 3 4
2 4 2 1
2 1 2 3
3 5 4 1
3 1 2 3 4
3 6 4 1
4 5 2 4 3
$EndElements
)";

TEST_F(GmshGroups, OfSeveralGroupsTheSmallestIsTakenAndTheOthersAreTold) {
  const auto source = open_and_compare("a.msh", kSeveral);
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:physical"), ElementsAre(4, 7, 2, 3));
  EXPECT_THAT(source->description().left_out,
              ElementsAre("elements of the physical groups 7, all that are in another one, too"));
  std::string one = kSeveral;
  one.replace(one.find("2 -7 4 1 4"), 10, "1 -7 1 4");
  EXPECT_THAT(open("b.msh", one)->description().left_out,
              ElementsAre("elements of the physical group all that are in another one, too"));
}

// The same, as version 2 has it: once for each group, turned round where the group is negative. The
// data have the last number of each.
const std::string kRepeated = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 4 "skin"
3 1 "all"
3 2 "left"
3 3 "right"
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
7
1 2 2 7 3 2 3 4
2 2 2 4 3 4 3 2
3 2 2 7 4 1 2 3
4 4 2 1 5 1 2 3 4
5 4 2 2 5 1 2 3 4
6 4 2 1 6 5 2 4 3
7 4 2 3 6 5 2 4 3
$EndElements
)";

std::string binary_repeated(bool swapped) {
  using Ints = std::vector<std::int32_t>;
  Bytes out(swapped);
  out.text("$MeshFormat\n2.2 1 8\n").put(std::int32_t{1}).text("\n$EndMeshFormat\n");
  const std::size_t names = kRepeated.find("$PhysicalNames");
  out.text(kRepeated.substr(names, kRepeated.find("1 0 0 0") - names));
  const std::vector<std::vector<double>> points = {
      {0, 0, 0}, {1, 0, 0.1}, {0, 1, 0}, {0, 0, 1}, {1, 1, -1}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.put(static_cast<std::int32_t>(i + 1)).put_all(points[i]);
  }
  out.text("\n$EndNodes\n$Elements\n7\n");
  out.put_all(Ints{2, 1, 2, 1, 7, 3, 2, 3, 4}).put_all(Ints{2, 1, 2, 2, 4, 3, 4, 3, 2});
  out.put_all(Ints{2, 1, 2, 3, 7, 4, 1, 2, 3});
  out.put_all(Ints{4, 4, 2, 4, 1, 5, 1, 2, 3, 4, 5, 2, 5, 1, 2, 3, 4, 6, 1, 6, 5, 2, 4, 3});
  out.put_all(Ints{7, 3, 6, 5, 2, 4, 3}).text("\n$EndElements\n");
  return out.str();
}

TEST_F(GmshGroups, Version2RepeatsElementsThatAreInSeveral) {
  const std::string expected = dump(open("a.msh", kSeveral).get());
  for (const std::string& bytes : {kRepeated, binary_repeated(false), binary_repeated(true)}) {
    const auto source = open_and_compare("b.msh", bytes);
    EXPECT_EQ(source->description().cells, 4u);
    EXPECT_EQ(dump(source.get()), expected);
    EXPECT_THAT(source->description().left_out,
                ElementsAre("elements of the physical groups 7, all that are in another one, too"));
  }
  const std::string data =
      "$ElementData\n1\n\"q\"\n0\n3\n0\n1\n4\n2 2.5\n3 3.5\n5 5.5\n7 7.5\n$EndElementData\n";
  const auto source = open_and_compare("b.msh", kRepeated + data);
  ASSERT_NE(source->stream(), nullptr);
  EXPECT_THAT(cell_values<double>(source.get(), "q"), ElementsAre(2.5, 3.5, 5.5, 7.5));
}

// Faults of the mesh stay: cells of one group, of none, or of different entities.
TEST_F(GmshGroups, OtherCellsThatAreThereTwiceStay) {
  for (const char* second :
       {"5 4 2 1 5 1 2 3 4", "5 4 2 0 5 1 2 3 4", "5 4 2 2 6 1 2 3 4", "5 4 2 2 5 5 2 3 4"}) {
    std::string mesh = kRepeated;
    mesh.replace(mesh.find("5 4 2 2 5 1 2 3 4"), 17, second);
    const auto source = open_and_compare("a.msh", mesh);
    EXPECT_EQ(source->description().cells, 5u) << second;
  }
}

// More than there are between two places that are kept in mind.
TEST_F(GmshGroups, ManyElementsMayBeRepeated) {
  std::string mesh = kRepeated.substr(0, kRepeated.find("7\n1 2 2 7"));
  constexpr int kElements = 9001;
  mesh += std::to_string(2 * kElements) + "\n";
  for (int i = 0; i < kElements; ++i) {
    for (int group = 1; group <= 2; ++group) {
      mesh += fmt::format("{} 4 2 {} {} 1 2 3 4\n", 2 * i + group, group + 2 * (i % 2), i % 3);
    }
  }
  const auto source = open_and_compare("a.msh", mesh + "$EndElements\n");
  EXPECT_EQ(source->description().cells, static_cast<std::uint64_t>(kElements));
  const auto groups = cell_values<std::int32_t>(source.get(), "gmsh:physical");
  const auto entities = cell_values<std::int32_t>(source.get(), "gmsh:geometrical");
  for (std::size_t i = 0; i < groups.size(); ++i) {
    ASSERT_EQ(groups[i], i % 2 == 0 ? 1 : 3) << i;
    ASSERT_EQ(entities[i], static_cast<std::int32_t>(i % 3)) << i;
  }
}

TEST_F(GmshGroups, DamagedRepetitionsAreNoCrash) {
  expect_no_crash("a.msh", kSeveral);
  expect_no_crash("a.msh", kRepeated);
  expect_no_crash("a.msh", binary_repeated(false));
}

// There may be many of these, before and between others.
TEST_F(GmshGroups, ValuesBetweenPartitionsArePassedOver) {
  std::string rows = "3 0.5\n";
  for (int i = 0; i < 9000; ++i) rows += i % 2 == 0 ? "1 -1\n" : "2 -2\n";
  const std::string head = "$ElementData\n1\n\"q\"\n0\n3\n0\n1\n9003\n";
  const std::string all = kParts + head + rows + "12 2\n11 4\n$EndElementData\n";
  const auto source = open_and_compare("a.msh", all);
  ASSERT_NE(source->stream(), nullptr);
  EXPECT_THAT(cell_values<double>(source.get(), "q"), ElementsAre(0.5, 2, 4));
}

// A tetrahedron and a triangle.
std::string small_text() {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
         "$EndNodes\n$Elements\n2\n1 2 2 1 1 1 2 3\n2 4 2 2 1 1 2 3 4\n$EndElements\n";
}

std::string small_binary() {
  Bytes out;
  out.text("$MeshFormat\n2.2 1 8\n").put(std::int32_t{1}).text("\n$EndMeshFormat\n$Nodes\n4\n");
  for (int v = 0; v < 4; ++v) {
    out.put(v + 1).put(v == 1 ? 1.0 : 0.0).put(v == 2 ? 1.0 : 0.0).put(v == 3 ? 1.0 : 0.0);
  }
  out.text("\n$EndNodes\n$Elements\n2\n").put_all(std::vector<int>{2, 1, 2, 1, 1, 1, 1, 2, 3});
  out.put_all(std::vector<int>{4, 1, 2, 2, 2, 1, 1, 2, 3, 4}).text("\n$EndElements\n");
  return out.str();
}

std::vector<std::string> all_variants(const std::string& names) {
  std::vector<std::string> meshes = {small_text(), small_binary(), kParts, binary_parts(true)};
  const std::string end = "$EndMeshFormat\n";
  for (std::string& mesh : meshes) mesh.insert(mesh.find(end) + end.size(), names);
  return meshes;
}

// Each dimension has names of its own.
TEST_F(GmshGroups, NamesAreOfOneDimension) {
  const std::string names =
      "$PhysicalNames\n4\n2 7 \"rock\"\n3 9 \"rock\"\n3 7 \"rock 2\"\n2 9 \"sand\"\n"
      "$EndPhysicalNames\n";
  WriteOptions text;
  text.encoding = Encoding::kAscii;
  for (const std::string& mesh : all_variants(names)) {
    const auto source = open_and_compare("a.msh", mesh);
    ASSERT_EQ(source->description().field_data.arrays.size(), 3u);
    EXPECT_EQ(source->description().field_data.arrays[0].name, "gmsh:physical:rock");
    EXPECT_THAT(values<std::int32_t>(source->read_array(Association::kField, 0)),
                ElementsAre(7, 2, 9, 3));
    convert(source.get(), "between.vtk");
    for (const char* from : {"a.msh", "between.vtk"}) {
      write_mesh(open_mesh(dir_.file(from)).get(), dir_.file("b.msh"), text);
      EXPECT_NE(bytes_of(dir_.file("b.msh")).find(names), std::string::npos) << from;
    }
  }
}

// Gmsh writes quotes in a name as they are.
TEST_F(GmshGroups, NamesMayHaveQuotes) {
  const std::string names =
      "$PhysicalNames\n3\n2 7 \"a \"wet\" sand\"\n3 9 \"\"all\"\"\n3 7 \"\"\n$EndPhysicalNames\n";
  for (const std::string& mesh : all_variants(names)) {
    const auto source = open_and_compare("a.msh", mesh);
    const auto& fields = source->description().field_data.arrays;
    ASSERT_EQ(fields.size(), 3u);
    EXPECT_EQ(fields[0].name, "gmsh:physical:a \"wet\" sand");
    EXPECT_EQ(fields[1].name, "gmsh:physical:\"all\"");
    EXPECT_EQ(fields[2].name, "gmsh:physical:");
    convert(source.get(), "b.msh");
    EXPECT_NE(bytes_of(dir_.file("b.msh")).find(names), std::string::npos);
  }
  for (const char* name : {"\"", "rock", "rock\""}) {
    std::string mesh = small_text();
    mesh.insert(mesh.find("$Nodes"),
                std::string("$PhysicalNames\n1\n3 1 ") + name + "\n$EndPhysicalNames\n");
    expect_error("a.msh", mesh, "line 6: expected a text in quotes");
  }
  for (const char* dimension : {"-2", "4"}) {
    std::string mesh = small_text();
    mesh.insert(mesh.find("$Nodes"),
                std::string("$PhysicalNames\n1\n") + dimension + " 1 \"a\"\n$EndPhysicalNames\n");
    expect_error("a.msh", mesh, "line 6: expected a dimension of 0 to 3, or -1");
  }
}

}  // namespace
}  // namespace tetfusion
