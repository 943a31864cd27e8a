// Data of a Gmsh file that each partition has a section of its own for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/data_array.h"
#include "support/format_files.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::cell_values;
using ::testing::ElementsAre;
using testing::point_values;

using GmshPartitions = testing::FormatTest;

const std::string kTwoTets = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
2
1 4 4 1 1 1 1 1 2 3 4
2 4 4 1 1 1 2 2 3 4 5
$EndElements
)";

std::string data(const std::string& kind, const std::string& time, int partition,
                 const std::string& rows) {
  const auto count = static_cast<int>(std::count(rows.begin(), rows.end(), '\n'));
  return "$" + kind + "\n1\n\"T\"\n1\n" + time + "\n4\n0\n1\n" + std::to_string(count) + "\n" +
         std::to_string(partition) + "\n" + rows + "$End" + kind + "\n";
}

std::vector<std::string> names(const AttributeSet& set) {
  std::vector<std::string> all;
  for (const ArrayInfo& info : set.arrays) all.push_back(info.name);
  return all;
}

TEST_F(GmshPartitions, SectionsOfOneArrayAreOneArray) {
  const auto source = open_and_compare(
      "a.msh",
      kTwoTets + data("NodeData", "0", 2, "5 5\n2 2\n") + data("ElementData", "0", 1, "1 10\n") +
          data("NodeData", "0", 1, "1 1\n2 2\n3 3\n4 4\n") + data("ElementData", "0", 2, "2 20\n"));
  EXPECT_THAT(names(source->description().point_data), ElementsAre("T"));
  EXPECT_THAT(point_values<double>(source.get(), "T"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(cell_values<double>(source.get(), "T"), ElementsAre(10, 20));
}

// In the order of the nodes, so that it is read in windows.
TEST_F(GmshPartitions, SectionsInOrderAreRead) {
  const auto source =
      open_and_compare("a.msh", kTwoTets + data("NodeData", "0", 1, "1 1\n2 2\n3 3\n") +
                                    data("NodeData", "0", 2, "4 4\n5 5\n"));
  ASSERT_NE(source->stream(), nullptr);
  EXPECT_THAT(point_values<double>(source.get(), "T"), ElementsAre(1, 2, 3, 4, 5));
}

// Two of one partition, or of none, are two arrays; so are two steps.
TEST_F(GmshPartitions, OtherSectionsStayApart) {
  const std::string first = data("NodeData", "0", 1, "1 1\n");
  const auto names_with = [&](const std::string& more) {
    return names(open("a.msh", kTwoTets + first + more)->description().point_data);
  };
  EXPECT_THAT(names_with(data("NodeData", "0", 1, "2 2\n")), ElementsAre("T", "T 2"));
  EXPECT_THAT(names_with(data("NodeData", "0", 0, "2 2\n")), ElementsAre("T", "T 2"));
  EXPECT_THAT(names_with(data("NodeData", "1", 2, "2 2\n")), ElementsAre("T at 0", "T at 1"));
  EXPECT_THAT(names_with(data("NodeData", "1", 1, "1 3\n") + data("NodeData", "0", 2, "2 2\n") +
                         data("NodeData", "1", 2, "2 4\n")),
              ElementsAre("T at 0", "T at 1"));
}

TEST_F(GmshPartitions, NumbersThatAreNotThereAreSaid) {
  expect_error("a.msh",
               kTwoTets + data("NodeData", "0", 1, "1 1\n") + data("NodeData", "0", 2, "9 9\n"),
               "line 39: \"T\" has a value for 9, which is not there");
}

TEST_F(GmshPartitions, BinarySections) {
  testing::Bytes out;
  out.text("$MeshFormat\n2.2 1 8\n").put(std::int32_t{1}).text("\n$EndMeshFormat\n$Nodes\n5\n");
  const std::vector<std::vector<double>> points{
      {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  std::int32_t number = 0;
  for (const auto& p : points) out.put(++number).put_all(p);
  out.text("\n$EndNodes\n$Elements\n2\n");
  out.put_all(std::vector<std::int32_t>{4, 2, 2, 1, 1, 1, 1, 2, 3, 4, 2, 1, 1, 2, 3, 4, 5});
  out.text("\n$EndElements\n");
  const auto put = [&](int partition, const std::vector<std::int32_t>& nodes) {
    out.text("$NodeData\n1\n\"T\"\n1\n0\n4\n0\n1\n" + std::to_string(nodes.size()) + "\n" +
             std::to_string(partition) + "\n");
    for (const std::int32_t node : nodes) out.put(node).put(10.0 * node);
    out.text("\n$EndNodeData\n");
  };
  put(1, {1, 2, 3, 4});
  put(2, {4, 5, 2});
  const auto source = open_and_compare("a.msh", out.str());
  EXPECT_THAT(names(source->description().point_data), ElementsAre("T"));
  EXPECT_THAT(point_values<double>(source.get(), "T"), ElementsAre(10, 20, 30, 40, 50));
  expect_no_crash("b.msh", out.str());
}

}  // namespace
}  // namespace tetfusion
