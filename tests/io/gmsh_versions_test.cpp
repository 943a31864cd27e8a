// Gmsh meshes of versions 1 and 4.0, and what other programs than Gmsh write.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/format_files.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::cell_values;
using testing::dump;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::replaced;
using testing::values;

using GmshVersions = testing::FormatTest;

// Of each field array the name, and its rows of tag and dimension.
using Groups = std::vector<std::pair<std::string, std::vector<std::int32_t>>>;
Groups groups_of(MeshSource* source) {
  Groups groups;
  const auto& arrays = source->description().field_data.arrays;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    groups.emplace_back(arrays[i].name,
                        values<std::int32_t>(source->read_array(Association::kField, i)));
  }
  return groups;
}

const std::string kValues = R"($ElementData
1
"flux"
0
3
0
1
1
12 2.5
$EndElementData
)";

// Numbers with gaps, in no order; a node that no element has.
const std::string kVersion1 = R"($NOD
6
10 0 0 0
20 1 0 0.1
7 0 1 0
40 0 0 1
50 1 1 -1
60 9 9 9
$ENDNOD
$ELM
5
3 2 7 3 3 20 7 40
1 15 0 1 1 7
12 4 9 5 4 10 20 7 40
11 4 9 6 4 50 20 40 7
2 1 0 4 2 10 20
$ENDELM
)" + kValues;

const std::string kVersion2 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
6
10 0 0 0
20 1 0 0.1
7 0 1 0
40 0 0 1
50 1 1 -1
60 9 9 9
$EndNodes
$Elements
5
3 2 2 7 3 20 7 40
1 15 2 0 1 7
12 4 2 9 5 10 20 7 40
11 4 2 9 6 50 20 40 7
2 1 2 0 4 10 20
$EndElements
)" + kValues;

// A box around each point; blocks that say tag before dimension; numbers beside the coordinates.
const std::string kVersion40 = R"($MeshFormat
4 0 8
$EndMeshFormat
$Entities
1 1 1 2
1 0 1 0 0 1 0 0
4 0 0 0 1 1 1 0 2 1 -1
3 0 0 0 1 1 1 1 -7 1 4
5 0 0 0 1 1 1 1 9 1 3
6 0 0 0 1 1 1 1 9 0
$EndEntities
$Nodes
3 6
5 3 0 2
10 0 0 0
20 1 0 0.1
1 0 0 0
3 2 1 4
7 0 1 0 0.25 0.5
40 0 0 1 0.25 0.5
50 1 1 -1 0 0
60 9 9 9 0 0
$EndNodes
$Elements
5 5
3 2 2 1
3 20 7 40
1 0 15 1
1 7
5 3 4 1
12 10 20 7 40
6 3 4 1
11 50 20 40 7
4 1 1 1
2 10 20
$EndElements
)" + kValues;

TEST_F(GmshVersions, AllMeanTheSame) {
  const auto first = open_and_compare("a.msh", kVersion1);
  EXPECT_EQ(first->description().format, "Gmsh mesh, 1, text");
  EXPECT_THAT(first->description().left_out, IsEmpty());
  expect_sample(first->read_geometry());
  EXPECT_THAT(cell_values<std::int32_t>(first.get(), "gmsh:physical"), ElementsAre(7, 0, 9, 9, 0));
  EXPECT_THAT(cell_values<std::int32_t>(first.get(), "gmsh:geometrical"),
              ElementsAre(3, 1, 5, 6, 4));
  EXPECT_EQ(cell_values<double>(first.get(), "flux")[2], 2.5);
  EXPECT_EQ(dump(first.get()), dump(open_and_compare("b.msh", kVersion2).get()));
  const auto fourth = open_and_compare("c.msh", kVersion40);
  EXPECT_EQ(fourth->description().format, "Gmsh mesh, 4.0, text");
  EXPECT_EQ(dump(first.get()), dump(fourth.get()));
  EXPECT_EQ(dump(first.get()),
            dump(open_and_compare("d.msh", replaced(kVersion40, "4 0 8", "4.0 0 8")).get()));
}

TEST_F(GmshVersions, VersionOneIsKnownByItsFirstWord) {
  EXPECT_EQ(open("a.dat", kVersion1)->description().format, "Gmsh mesh, 1, text");
}

TEST_F(GmshVersions, OtherVersionsAreRefused) {
  expect_error("a.msh", replaced(kVersion40, "4 0 8", "3 0 8"), "a Gmsh file of version '3'");
  expect_error("a.msh", replaced(kVersion40, "4 0 8", "4.2 0 8"), "a Gmsh file of version '4.2'");
  expect_error("a.msh", replaced(kVersion40, "4 0 8", "4 1 8"),
               "a binary Gmsh file of version 4.0, which only Gmsh 4.0 reads");
}

TEST_F(GmshVersions, SayWhatIsWrongAndWhere) {
  const std::string& one = kVersion1;
  expect_error("a.msh", replaced(one, "9 5 4 10", "9 5 5 10"),
               "line 14: expected 4 nodes, found 5");
  expect_error("a.msh", replaced(one, "50 20 40 7", "51 20 40 7"),
               "line 15: element 11 uses node 51, which is not there");
  expect_error("a.msh", replaced(one, "$NOD\n6", "$NOD\n7"), "the section ends too early");
  expect_error("a.msh", replaced(one, "$NOD\n6", "$NOD\n5"), "expected the section's end");
  expect_error("a.msh", replaced(one, "$ELM\n5", "$ELM\n4"), "expected the section's end");
  expect_error("a.msh", replaced(one, "$ENDNOD", "$EndNOD"), "line 1: $NOD: there is no $ENDNOD");
  const std::string& four = kVersion40;
  expect_error("a.msh", replaced(four, "3 6\n5 3", "3 7\n5 3"), "expected 7 nodes, found 6");
  expect_error("a.msh", replaced(four, "3 6\n5 3", "3 5\n5 3"), "more nodes than the 5 announced");
  expect_error("a.msh", replaced(four, "5 5\n3 2", "5 4\n3 2"),
               "more elements than the 4 announced");
  expect_error("a.msh", replaced(four, "3 2 1 4", "3 4 1 4"), "expected a dimension of 0 to 3");
  expect_error("a.msh", replaced(four, "40 0 0 1 0.25", "-4 0 0 1 0.25"),
               "line 19: a node has the number -4");
  expect_error("a.msh", replaced(four, "60 9 9 9 0 0", "60 9 9 9 0"), "");
}

TEST_F(GmshVersions, SurviveDamage) {
  for (const std::string& text : {kVersion1, kVersion40}) expect_no_crash("a.msh", text);
}

// Arrays come last: without them a file is whole.
TEST_F(GmshVersions, AreNeverReadByHalf) {
  for (const std::string& text : {kVersion1, kVersion40}) {
    expect_no_half_mesh("a.msh", text.substr(0, text.find("$ElementData")));
  }
}

// More rows than lie between two places from which they are read, in blocks of other lengths.
TEST_F(GmshVersions, AreReadFromAnyPlace) {
  constexpr int kNodes = 10000;
  constexpr int kBlock = 1500;
  const auto blocks = [&](int rows, const std::string& head, const auto& row) {
    std::string text = fmt::format("{} {}\n", (rows + kBlock - 1) / kBlock, rows);
    for (int i = 0; i < rows; ++i) {
      if (i % kBlock == 0) text += fmt::format("{} {}\n", head, std::min(kBlock, rows - i));
      text += row(i);
    }
    return text;
  };
  const auto node = [](int i) {
    return fmt::format("{} {} {} {}\n", 3 * i + 1, i, i % 7, i * i % 11);
  };
  const auto nodes_of = [](int i) {
    return fmt::format("{} {} {} {}\n", 3 * i + 1, 3 * i + 4, 3 * i + 7, 3 * i + 10);
  };
  std::string one = fmt::format("$NOD\n{}\n", kNodes);
  for (int i = 0; i < kNodes; ++i) one += node(i);
  one += fmt::format("$ENDNOD\n$ELM\n{}\n", kNodes - 3);
  for (int i = 0; i < kNodes - 3; ++i) one += fmt::format("{} 4 0 5 4 {}", i + 1, nodes_of(i));
  one += "$ENDELM\n";
  const std::string four =
      "$MeshFormat\n4 0 8\n$EndMeshFormat\n$Nodes\n" + blocks(kNodes, "5 3 0", node) +
      "$EndNodes\n$Elements\n" +
      blocks(kNodes - 3, "5 3 4", [&](int i) { return fmt::format("{} {}", i + 1, nodes_of(i)); }) +
      "$EndElements\n";
  const auto source = open_and_compare("a.msh", one);
  EXPECT_EQ(source->read_geometry().tets.size(), std::size_t{kNodes - 3});
  EXPECT_EQ(dump(source.get()), dump(open_and_compare("b.msh", four).get()));
}

// Version 1 has an element of two groups twice, as version 2.
TEST_F(GmshVersions, RepeatedElementsAreOne) {
  const std::string twice = replaced(replaced(kVersion1, "$ELM\n5", "$ELM\n6"), "11 4 9 6",
                                     "13 4 8 5 4 10 20 7 40\n11 4 9 6");
  const auto source = open_and_compare("a.msh", replaced(twice, "\n12 2.5", "\n13 2.5"));
  EXPECT_EQ(source->description().cells, 5u);
  EXPECT_THAT(source->description().left_out,
              ElementsAre("elements of the physical group 9 that are in another one, too"));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "gmsh:physical"), ElementsAre(7, 0, 8, 9, 0));
}

TEST_F(GmshVersions, NamesWithoutADimensionGoWithAllGroupsOfTheirTag) {
  const std::string names =
      "$PhysicalNames\n4\n9 \"the body\"\n  7\"inlet\"\n3 4 \"known\"\n99 \"nobody\"\n"
      "$EndPhysicalNames\n";
  const std::string mesh = replaced(kVersion2, "2 1 2 0 4", "2 1 2 9 4");
  const Groups expected = {{"gmsh:physical:the body", {9, 1, 9, 3}},
                           {"gmsh:physical:inlet", {7, 2}},
                           {"gmsh:physical:known", {4, 3}}};
  for (const char* version : {"2 0 8", "2.2 0 8"}) {
    const std::string text = replaced(mesh, "2.2 0 8", version);
    for (const std::string& whole : {text + names, replaced(text, "$Nodes", names + "$Nodes")}) {
      const auto source = open_and_compare("a.msh", whole);
      EXPECT_EQ(groups_of(source.get()), expected);
      EXPECT_THAT(source->description().left_out,
                  ElementsAre("the name nobody of what has no elements"));
    }
  }
  EXPECT_EQ(groups_of(open_and_compare("b.msh", kVersion1 + names).get()),
            (Groups{{"gmsh:physical:the body", {9, 3}},
                    {"gmsh:physical:inlet", {7, 2}},
                    {"gmsh:physical:known", {4, 3}}}));
}

// Gmsh 4.0 writes -1 for what a file of version 2.0 did not say.
TEST_F(GmshVersions, ADimensionOfMinusOneIsNone) {
  const std::string names = "$PhysicalNames\n1\n-1 9 \"the body\"\n$EndPhysicalNames\n";
  for (const std::string& text : {kVersion2, kVersion40}) {
    EXPECT_EQ(groups_of(open_and_compare("a.msh", text + names).get()),
              (Groups{{"gmsh:physical:the body", {9, 3}}}));
  }
}

TEST_F(GmshVersions, WordsBehindANameAreTold) {
  const std::string names =
      "$PhysicalNames\n2\n3 9 \"the \"big\" body\" lower_dimensional_block\n2 7 \"inlet\"  \r\n"
      "$EndPhysicalNames\n";
  for (const std::string& text : {kVersion2, kVersion40}) {
    const auto source = open_and_compare("a.msh", text + names);
    EXPECT_EQ(groups_of(source.get()), (Groups{{"gmsh:physical:the \"big\" body", {9, 3}},
                                               {"gmsh:physical:inlet", {7, 2}}}));
    EXPECT_THAT(source->description().left_out, ElementsAre("words behind the names of groups"));
  }
}

TEST_F(GmshVersions, NamesThatCannotBeReadAreRefused) {
  const auto expect = [&](const std::string& text, const std::string& row,
                          const std::string& words) {
    expect_error("a.msh", text + "$PhysicalNames\n1\n" + row + "\n$EndPhysicalNames\n", words);
  };
  expect(kVersion2, "3 9 body", "line 33: expected a text in quotes");
  expect(kVersion2, "3 9 \"body", "line 33: expected a text in quotes");
  expect(kVersion2, "\"body\"", "line 33: expected the dimension and tag of a group");
  expect(kVersion2, "3 9 1 \"body\"", "line 33: expected the dimension and tag of a group");
  expect(kVersion2, "x \"body\"", "line 33: expected a whole number, found 'x'");
  expect(kVersion40, "9 \"body\"", "expected the dimension and tag of a group");
}

TEST_F(GmshVersions, NamesOfDataNeedNoQuotes) {
  for (const std::string name : {"flux", "  two words \r", "\"flux\""}) {
    const auto source = open_and_compare("a.msh", replaced(kVersion2, "\"flux\"", name));
    const std::string expected = name.find("two") == name.npos ? "flux" : "two words";
    EXPECT_EQ(cell_values<double>(source.get(), expected)[2], 2.5);
  }
  expect_error("a.msh", replaced(kVersion2, "\"flux\"\n0", "\n0\n0"),
               "line 24: expected a text in quotes");
  expect_error("a.msh", replaced(kVersion2, "\"flux\"", "flux\""),
               "line 23: expected a text in quotes");
}

}  // namespace
}  // namespace tetfusion
