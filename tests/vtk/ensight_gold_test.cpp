#include "vtk/ensight_gold.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace tetfusion {
namespace {

using ::testing::HasSubstr;

std::string lines(int count, const std::string& line) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line + "\n";
  return text;
}

// Two parts; ids of nodes, polygons and polyhedra in the second one.
std::string geometry() {
  return "about\nit\nnode id given\nelement id off\nextents\n" + lines(3, "0 1") +
         "part\n1\na part\ncoordinates\n3\n" + lines(3, "7") + lines(9, "0.5") + "tria3\n2\n" +
         lines(2, "1 2 3") + "part\n 2\nanother\ncoordinates\n4\n" + lines(4, "7") +
         lines(12, "0.5") + "nsided\n1\n3\n1 2 3\nnfaced\n2\n4\n1\n" + lines(5, "3") +
         lines(5, "1 2 3");
}

TEST(EnSightGold, KnowsAWholeGeometry) {
  for (const bool is_of_windows : {false, true}) {
    std::string text = geometry();
    for (std::size_t at = 0; is_of_windows && (at = text.find('\n', at)) != std::string::npos;) {
      text.replace(at, 1, "\r\n");
      at += 2;
    }
    EnSightGold gold;
    EXPECT_EQ(gold.fault_of_geometry(text), "");
    const std::string nodes =
        "v\npart\n1\ncoordinates\n" + lines(3, "1.5") + "part\n2\ncoordinates\n";
    EXPECT_EQ(gold.fault_of_variable(nodes + lines(4, "1.5"), 1), "");
    EXPECT_THAT(gold.fault_of_variable(nodes + lines(3, "1.5"), 1),
                HasSubstr("not as many values as there are of 'coordinates' in part 2"));
    EXPECT_THAT(gold.fault_of_variable(nodes + lines(4, "1.5"), 3),
                HasSubstr("'coordinates' in part 1"));
    const std::string elements = "v\npart\n2\nnsided\n1\nnfaced\n2\n";
    EXPECT_EQ(gold.fault_of_variable(elements + "3\n", 1), "");
    EXPECT_THAT(gold.fault_of_variable(elements, 1), HasSubstr("'nfaced' in part 2"));
    // Of what is not known nothing is said.
    for (const char* other :
         {"v\npart\n3\ncoordinates\n1\n", "v\npart\n1\ncoordinates undef\n", "v\n1\n", ""}) {
      EXPECT_EQ(gold.fault_of_variable(other, 1), "");
    }
  }
}

// At the end of any line behind the head of the second part, and never beyond the text.
TEST(EnSightGold, KnowsWhatIsCutOff) {
  const std::string text = geometry();
  const std::size_t second = text.find("another\ncoordinates\n4\n") + 8;
  for (std::size_t size = 0; size < text.size(); ++size) {
    EnSightGold gold;
    const std::string fault = gold.fault_of_geometry(std::string_view(text).substr(0, size));
    if (size < second || text[size - 1] != '\n') continue;
    const std::string last = text.substr(second, size - second);
    const bool ends_with_a_section = last.ends_with("nsided\n1\n3\n1 2 3\n") || last.size() == 0 ||
                                     last == "coordinates\n4\n" + lines(4, "7") + lines(12, "0.5");
    EXPECT_EQ(fault.empty(), ends_with_a_section) << last << fault;
  }
}

TEST(EnSightGold, LeavesOtherThingsAlone) {
  for (const char* text :
       {"", "a\nb\nc\nd\n", "a\nb\nnode id off\nelement id off\npart\n1\nx\nblock\n2 2 2\n",
        "a\nb\nnode id off\nelement id off\npart\nx\n"}) {
    EnSightGold gold;
    EXPECT_EQ(gold.fault_of_geometry(text), "");
    EXPECT_EQ(gold.fault_of_variable("v\npart\n1\ncoordinates\n", 1), "");
  }
  EnSightGold gold;
  EXPECT_THAT(gold.fault_of_geometry("a\nb\nnode id off\nelement id off\npart\n1\nx\ncoordinates\n"
                                     "18446744073709551615\n1\n"),
              HasSubstr("ends before"));
}

}  // namespace
}  // namespace tetfusion
