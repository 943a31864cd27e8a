#include "series/series_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/vtk/series_list.h"
#include "series/step_labels.h"
#include "support/temp_dir.h"
#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using testing::TempDir;

void expect_bad(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
  try {
    read_series_list(path);
    ADD_FAILURE() << text;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput) << error.what();
  }
}

TEST(StepLabels, AreWhatDiffersBetweenNames) {
  EXPECT_THAT(label_steps({"a_1.vtu", "a_2.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"x/cold.vtu", "x/warm.vtu"}), ElementsAre("cold", "warm"));
  EXPECT_THAT(label_steps({"a.x.1.vtu", "a.y.2.vtu"}), ElementsAre("x.1", "y.2"));
}

// As OpenFOAM's foamToVTK writes them.
TEST(StepLabels, AreWhatDiffersBetweenFoldersOfFilesOfOneName) {
  EXPECT_THAT(label_steps({"case_0/internal.vtu", "case_100/internal.vtu"}),
              ElementsAre("0", "100"));
  EXPECT_THAT(label_steps({"/a/1/vtk/m.vtu", "/a/2/vtk/m.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"1/m.vtu", "2/m.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"m.vtu", "1/m.vtu"}), ElementsAre("0", "1"));
}

TEST(StepLabels, HaveWholeNumbers) {
  EXPECT_THAT(label_steps({"s010.vtu", "s011.vtu"}), ElementsAre("010", "011"));
  EXPECT_THAT(label_steps({"s10.vtu", "s20.vtu"}), ElementsAre("10", "20"));
  EXPECT_THAT(label_steps({"s1.vtu", "s11.vtu", "s111.vtu"}), ElementsAre("1", "11", "111"));
  EXPECT_THAT(label_steps({"t3_s1.vtu", "t3_s2.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"run7.vtu"}), ElementsAre("7"));
}

TEST(StepLabels, HaveWholeNumbersWithSignsPointsAndExponents) {
  EXPECT_THAT(label_steps({"t_0.25.vtu", "t_0.5.vtu", "t_0.75.vtu"}),
              ElementsAre("0.25", "0.5", "0.75"));
  EXPECT_THAT(label_steps({"t0.25.vtu", "t0.35.vtu"}), ElementsAre("0.25", "0.35"));
  EXPECT_THAT(label_steps({"q_0.5.vtu", "q_10.0.vtu", "q_2.0.vtu"}),
              ElementsAre("0.5", "10.0", "2.0"));
  EXPECT_THAT(label_steps({"t_0.vtu", "t_0.5.vtu"}), ElementsAre("0", "0.5"));
  EXPECT_THAT(label_steps({"t_-1.vtu", "t_-2.vtu"}), ElementsAre("-1", "-2"));
  EXPECT_THAT(label_steps({"t_-1.vtu", "t_1.vtu"}), ElementsAre("-1", "1"));
  EXPECT_THAT(label_steps({"t_1e-05.vtu", "t_1e-04.vtu"}), ElementsAre("1e-05", "1e-04"));
  EXPECT_THAT(label_steps({"0.1/m.vtu", "0.15/m.vtu"}), ElementsAre("0.1", "0.15"));
  EXPECT_THAT(label_steps({"out-0.5.vtu"}), ElementsAre("0.5"));
}

// What stands before a number may be no part of it.
TEST(StepLabels, TellNumbersFromPartsOfNames) {
  EXPECT_THAT(label_steps({"part2.0009.vtu", "part2.0010.vtu"}), ElementsAre("0009", "0010"));
  EXPECT_THAT(label_steps({"run-1.vtu", "run-2.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"case1e1.vtu", "case1e2.vtu"}), ElementsAre("1", "2"));
  EXPECT_THAT(label_steps({"2024.01.05.vtu", "2024.01.06.vtu"}), ElementsAre("05", "06"));
  EXPECT_THAT(label_steps({"2024-01-05.vtu", "2024-01-06.vtu"}), ElementsAre("05", "06"));
}

// As long as doubles, and whole numbers, are.
TEST(StepLabels, AreNumbersOfAnyLength) {
  for (const char* const label : {"0.30000000000000004", "18446744073709551615", "-0.1", "1e-05"}) {
    EXPECT_TRUE(is_number_label(label)) << label;
  }
  EXPECT_FALSE(is_number_label("final"));
  EXPECT_LT(number_in("0.2"), number_in("0.30000000000000004"));
  EXPECT_LT(number_in("0.30000000000000004"), number_in("0.4"));
  EXPECT_LT(number_in("18446744073709551614"), number_in("18446744073709551615"));
  EXPECT_LT(number_in("999"), number_in("123456789012345678901234567890"));
}

TEST(StepLabels, CountWhereNamesTellNothing) {
  EXPECT_THAT(label_steps({"a/m.vtu", "a/m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"/m.vtu", "/m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"m.vtu", "m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"aa.vtu", "a.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"mesh.vtu"}), ElementsAre("0"));
  const std::vector<std::string> labels = label_steps(std::vector<std::string>(101, "m.vtu"));
  EXPECT_EQ(labels.front(), "000");
  EXPECT_EQ(labels.back(), "100");
}

TEST(StepNames, SayWhetherItIsASeries) {
  EXPECT_FALSE(is_series({"a.vtu"}, "b.vtu", {}));
  EXPECT_TRUE(is_series({"a.vtu", "b.vtu"}, "c.vtu", {}));
  EXPECT_TRUE(is_series({"a.vtu"}, "{step}.vtu", {}));
  EXPECT_TRUE(is_series({"a.PVD"}, "b.vtu", {}));
  EXPECT_TRUE(is_series({"a.vtu"}, "b.pvd", {}));
  EXPECT_TRUE(is_series({"a.vtu"}, "b.vtu", {"f", "g_{step}:1%"}));
  EXPECT_FALSE(is_series({"a.vtu"}, "b.vtu", {"f"}));
}

// VTK, which is tried in a child process, says which steps there are.
class StepsWithVtk : public testing::VtkFileTest {
 protected:
  void SetUp() override {
    testing::VtkFileTest::SetUp();
    request_.job.output = dir_.file("out_{step}.vtu");
  }
  void expect_that_it_ends_when_told(std::size_t steps) {
    std::atomic<bool> cancelled{false};
    RunContext context;
    context.cancelled = &cancelled;
    EXPECT_EQ(plan_series(request_, context).steps.size(), steps);
    cancelled = true;
    try {
      plan_series(request_, context);
      ADD_FAILURE() << "the plan was made all the same";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInterrupted) << error.what();
    }
  }

  SeriesRequest request_;
};

TEST_F(StepsWithVtk, OfAFileAreAskedForUntilTheCallerHasEnough) {
  for (const auto* const name : {"mesh.geo0", "mesh.geo1"}) {
    write(name,
          "a mesh\nby hand\nnode id off\nelement id off\npart\n1\nrock\ncoordinates\n4\n"
          "0\n1\n0\n0\n0\n0\n1\n0\n0\n0\n0\n1\ntetra4\n1\n1 2 3 4\n");
  }
  request_.inputs = {write("run.case",
                           "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: 1 mesh.geo*\nTIME\n"
                           "time set: 1\nnumber of steps: 2\nfilename start number: 0\n"
                           "filename increment: 1\ntime values: 0.5 1.5\n")};
  expect_that_it_ends_when_told(2);
}

TEST_F(StepsWithVtk, ThatAreArraysAreAskedForUntilTheCallerHasEnough) {
  request_.inputs = {write("mesh.vtk", testing::kStructured)};
  request_.job.behaviour.arrays = {"hei{step}"};
  request_.job.output = dir_.file("out.vtu");
  expect_that_it_ends_when_told(1);
}

TEST(PvdFile, ComesBackAsItWasWritten) {
  const TempDir dir;
  const std::string path = dir.file("run.pvd");
  write_pvd(path, {{0.1, dir.file("a&b.vtu")}, {-2, dir.file("x/c.vtu")}});
  const std::vector<ListedStep> steps = read_series_list(path);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].time, -2);
  EXPECT_EQ(steps[0].path, dir.file("x/c.vtu"));
  EXPECT_EQ(steps[1].time, 0.1);
  EXPECT_EQ(steps[1].path, dir.file("a&b.vtu"));
}

TEST(PvdFile, StepsWithoutTimesStayInTheirOrder) {
  const TempDir dir;
  const std::string path = dir.file("run.pvd");
  std::ofstream(path)
      << "<VTKFile><Collection><DataSet file='b'/><DataSet file='a'/></Collection></VTKFile>";
  const std::vector<ListedStep> steps = read_series_list(path);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].path, dir.file("b"));
  EXPECT_EQ(steps[1].time, std::nullopt);
}

// As programs on Windows write them, and with names that go about.
TEST(PvdFile, LineEndsAndAMarkOfByteOrderAreNoMatter) {
  const TempDir dir;
  const std::string path = dir.file("run.pvd");
  std::ofstream(path)
      << "\xEF\xBB\xBF<?xml version=\"1.0\"?>\r\n<VTKFile type='Collection'>\r\n"
         "<Collection>\r\n<DataSet timestep='2' part='0' file='./sub/../b.vtu'/>\r\n"
         "<DataSet timestep='1' part='0' file='./a.vtu'/>\r\n</Collection>\r\n"
         "</VTKFile>\r\n";
  const std::vector<ListedStep> steps = read_series_list(path);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].path, dir.file("a.vtu"));
  EXPECT_EQ(steps[1].path, dir.file("b.vtu"));
}

TEST(SeriesFile, NamesStepsAndTimes) {
  const TempDir dir;
  const std::string path = dir.file("run.vtu.series");
  std::ofstream(path) << R"({"file-series-version": "1.0", "files": [
      {"name": "late.vtu", "time": 2.5}, {"name": "sub/early.vtu", "time": 1}]})";
  const std::vector<ListedStep> steps = read_series_list(path);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].time, 1);
  EXPECT_EQ(steps[0].path, dir.file("sub/early.vtu"));
  EXPECT_EQ(steps[1].time, 2.5);
  EXPECT_TRUE(is_series({path}, "b.vtu", {}));
}

TEST(SeriesFile, BadOnesAreBadInput) {
  const TempDir dir;
  const std::string path = dir.file("run.vtu.series");
  for (const std::string text :
       {"", "[1", "[]", R"({"files": 1})", R"({"files": []})", R"({"files": [{"time": 1}]})",
        R"({"files": [{"name": "a", "time": "x"}]})", R"({"files": [{"name": "/a", "time": 1}]})",
        R"({"files": [{"name": "a", "time": 1}, {"name": "b", "time": 1}]})"}) {
    expect_bad(path, text);
  }
}

TEST(PvdFile, BadOnesAreBadInput) {
  const TempDir dir;
  const std::string path = dir.file("run.pvd");
  for (const std::string text :
       {"<VTKFile>", "<a/>", "<VTKFile><Collection/></VTKFile>",
        "<VTKFile><Collection><DataSet file='a'/><DataSet timestep='1' file='b'/></Collection>"
        "</VTKFile>",
        "<VTKFile><Collection><DataSet timestep='1e999' file='a'/></Collection></VTKFile>",
        "<VTKFile><Collection><DataSet part='0' file='a'/><DataSet part='1' file='b'/></Collection>"
        "</VTKFile>",
        "<VTKFile><Collection><DataSet timestep='1'/></Collection></VTKFile>"}) {
    expect_bad(path, text);
  }
}

}  // namespace
}  // namespace tetfusion
