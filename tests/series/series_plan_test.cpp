#include "series/series_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/series_list.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using testing::TempDir;

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

TEST(StepLabels, CountWhereNamesTellNothing) {
  EXPECT_THAT(label_steps({"a/m.vtu", "a/m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"/m.vtu", "/m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"m.vtu", "m.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"aa.vtu", "a.vtu"}), ElementsAre("0", "1"));
  EXPECT_THAT(label_steps({"mesh.vtu"}), ElementsAre("0"));
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

TEST(PvdFile, StepsWithoutTimesAreNumbered) {
  const TempDir dir;
  const std::string path = dir.file("run.pvd");
  std::ofstream(path)
      << "<VTKFile><Collection><DataSet file='b'/><DataSet file='a'/></Collection></VTKFile>";
  const std::vector<ListedStep> steps = read_series_list(path);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].path, dir.file("b"));
  EXPECT_EQ(steps[1].time, 1);
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
    std::ofstream(path) << text;
    try {
      read_series_list(path);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput) << error.what();
    }
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
        "<VTKFile><Collection><DataSet timestep='1'/></Collection></VTKFile>"}) {
    std::ofstream(path) << text;
    try {
      read_series_list(path);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput) << error.what();
    }
  }
}

}  // namespace
}  // namespace tetfusion
