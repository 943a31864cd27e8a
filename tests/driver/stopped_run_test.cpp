// Runs that are stopped on the way, and gone on with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <set>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "driver/rounds/memory_plan.h"
#include "driver/simplify.h"
#include "support/mesh_file.h"
#include "support/out_of_core_run.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::rich_box;

constexpr double kOff = std::numeric_limits<double>::infinity();

// Stopped anywhere, and gone on with.
class StoppedRun : public testing::OutOfCoreRun {
 protected:
  void expect_same_bytes_wherever_it_stops() {
    const std::string expected = run_in_core();
    int stops_with_work = 0;
    for (const int report : stops()) {
      std::filesystem::remove(request.output);
      request.performance = {};
      request.performance.on_disk = true;
      const auto message = run_until(report);
      if (!message) {  // threads report a percent once or twice: this time it was not so many
        EXPECT_EQ(take_output() == expected, true) << "not stopped at report " << report;
        continue;
      }
      const bool keeps_work = message->find("--resume") != std::string::npos;
      EXPECT_EQ(files(),
                keeps_work ? std::set<std::string>{"out.vtu.tetfusion"} : std::set<std::string>{});
      stops_with_work += keeps_work ? 1 : 0;
      request.performance.resume = true;
      request.performance.threads = 1 + report % 3;
      simplify(request);
      EXPECT_EQ(files(), std::set<std::string>{"out.vtu"});
      EXPECT_EQ(take_output() == expected, true) << "stopped at report " << report;
    }
    EXPECT_GE(stops_with_work, 8);
  }
};

TEST_F(StoppedRun, EndsInTheSameBytesWithoutAGoal) { expect_same_bytes_wherever_it_stops(); }

TEST_F(StoppedRun, EndsInTheSameBytesWithAGoal) {
  // A goal that no fusion meets exactly: the last rounds find that out.
  request.behaviour.tets = 5000;
  expect_same_bytes_wherever_it_stops();
}

TEST_F(StoppedRun, EndsInTheSameBytesWhenItFuses) {
  fuse(std::nullopt);
  expect_same_bytes_wherever_it_stops();
}

TEST_F(StoppedRun, EndsInTheSameBytesWithABoundAtPoints) {
  fuse(std::nullopt);
  request.behaviour.max_rms.reset();
  request.behaviour.max_error = 0.05;
  expect_same_bytes_wherever_it_stops();
}

TEST_F(StoppedRun, EndsInTheSameBytesWhenItFusesTowardsAGoal) {
  fuse(0.5);
  expect_same_bytes_wherever_it_stops();
}

TEST_F(StoppedRun, EndsInTheSameBytesWhenTheBoundaryMoves) {
  fuse(0.6);
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.01;
  expect_same_bytes_wherever_it_stops();
}

TEST_F(StoppedRun, EndsInTheSameBytesWithFloats) {
  MeshFile file = rich_box(9);
  file.geometry = testing::to_float(file.geometry);
  file.write(request.input);
  request.behaviour.scalar_tolerance = {0.05, 0.1, kOff};
  request.behaviour.stretch_factor = {2, 5};
  request.behaviour.regions.emplace();
  expect_same_bytes_wherever_it_stops();
}

// Stopped again and again, each time a little later.
TEST_F(StoppedRun, ComesToAnEnd) {
  const std::string expected = run_in_core();
  request.performance.on_disk = true;
  request.performance.resume = true;
  int stops = 0;
  while (run_until(5 + stops / 4)) ASSERT_LT(++stops, 100);
  EXPECT_GT(stops, 3);
  EXPECT_EQ(take_output() == expected, true);
  EXPECT_TRUE(files().empty());
}

// By either method.
class StoppedLevels : public StoppedRun, public ::testing::WithParamInterface<Method> {};

TEST_P(StoppedLevels, StayWhenTheyAreWhole) {
  request.behaviour.method = GetParam();
  request.output = folder.file("level_{lod}.vtu");
  request.performance.scratch = folder.file("scratch");
  request.behaviour.lods = {0.1, 0.2};
  request.behaviour.scalar_tolerance = {kOff};
  const auto level = [&](int i) { return folder.file("level_" + std::to_string(i) + ".vtu"); };
  SimplifyRequest in_core = request;
  simplify(in_core);
  const std::string first = bytes_of(level(1)), second = bytes_of(level(2));
  ASSERT_FALSE(first.empty());
  ASSERT_NE(first, second);
  int stopped_between = 0;
  for (const int report : stops()) {
    std::filesystem::remove(level(1));
    std::filesystem::remove(level(2));
    request.performance.on_disk = true;
    request.performance.resume = false;
    ASSERT_TRUE(run_until(report));
    if (std::filesystem::exists(level(1))) {
      ++stopped_between;
      EXPECT_EQ(bytes_of(level(1)) == first, true);
    }
    EXPECT_FALSE(std::filesystem::exists(level(2)));
    request.performance.resume = true;
    simplify(request);
    EXPECT_EQ(bytes_of(level(1)) == first, true) << report;
    EXPECT_EQ(bytes_of(level(2)) == second, true) << report;
    EXPECT_EQ(files(), (std::set<std::string>{"level_1.vtu", "level_2.vtu"}));
  }
  EXPECT_GT(stopped_between, 1);
}

// The first level was written with a map of another name: the run that goes on cannot make it.
TEST_F(StoppedRun, LevelsThatAreThereGetNoOtherMap) {
  request.output = folder.file("level_{lod}.vtu");
  request.performance.scratch = folder.file("scratch");
  request.behaviour.method = Method::kFuse;
  request.behaviour.lods = {0.1, 0.3, 0.5};
  request.performance.on_disk = true;
  int refused = 0;
  for (const int report : stops()) {
    std::filesystem::remove(folder.file("level_1.vtu"));
    std::filesystem::remove_all(folder.file("scratch"));
    request.performance.resume = false;
    request.map = folder.file("first_{lod}.map");
    ASSERT_TRUE(run_until(report));
    if (!std::filesystem::exists(folder.file("level_1.vtu"))) continue;
    request.performance.resume = true;
    request.map = folder.file("level_{lod}.map");
    std::string said;
    try {
      simplify(request);  // killed before it was noted that the level is there
      for (const char* level : {"1", "2", "3"}) {
        EXPECT_TRUE(std::filesystem::remove(folder.file(std::string("level_") + level + ".map")));
      }
    } catch (const Error& e) {
      ++refused;
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      EXPECT_THAT(e.what(), HasSubstr("level_1.map"));
      EXPECT_THAT(e.what(), ::testing::Not(HasSubstr("the same command")));
      request.verify = true;
      RunContext context;
      context.notice = [&](std::string_view sentence) { said += sentence; };
      request.map = folder.file("first_{lod}.map");
      EXPECT_LT(simplify(request, context).verified.size(), 3u);
      EXPECT_THAT(said, HasSubstr("--verify looks at the levels that are written from here on"));
      break;
    }
  }
  EXPECT_EQ(refused, 1);
}

INSTANTIATE_TEST_SUITE_P(Methods, StoppedLevels,
                         ::testing::Values(Method::kTetFuse, Method::kFuse));

TEST_F(StoppedRun, InMemoryLeavesNothing) {
  for (int report = 1; run_until(report); report += 3) EXPECT_TRUE(files().empty());
  EXPECT_EQ(files(), std::set<std::string>{"out.vtu"});
}

TEST_F(StoppedRun, IsRefusedWithOtherOptionsAndAnotherInput) {
  const std::string expected = run_in_core();
  request.performance.on_disk = true;
  ASSERT_TRUE(run_until(3, "fusing"));
  ASSERT_TRUE(std::filesystem::exists(scratch()));
  std::string message;
  EXPECT_EQ(refusal(&message), ErrorCode::kUsage);  // without --resume
  EXPECT_THAT(message, HasSubstr("--resume"));

  request.performance.resume = true;
  const SimplifyRequest same = request;
  request.behaviour.stretch_factor = {4};
  EXPECT_EQ(refusal(&message), ErrorCode::kUsage);
  EXPECT_THAT(message, HasSubstr("stretch factor"));
  request = same;
  request.behaviour.chunk_tets = 701;
  EXPECT_EQ(refusal(), ErrorCode::kUsage);
  request = same;
  request.behaviour.method = Method::kFuse;
  EXPECT_EQ(refusal(&message), ErrorCode::kUsage);
  EXPECT_THAT(message, HasSubstr("method"));
  request = same;
  request.encoding = Encoding::kZlib;
  EXPECT_EQ(refusal(), ErrorCode::kUsage);
  request = same;
  const auto changed = std::filesystem::last_write_time(request.input);
  std::filesystem::last_write_time(request.input, changed + std::chrono::seconds(1));
  EXPECT_EQ(refusal(&message), ErrorCode::kUsage);
  EXPECT_THAT(message, HasSubstr("input"));
  std::filesystem::last_write_time(request.input, changed);
  EXPECT_EQ(files(), std::set<std::string>{"out.vtu.tetfusion"});

  simplify(request);  // after all that the work is still there
  EXPECT_EQ(take_output() == expected, true);
}

// Another mesh of the same size, through a pipe of the same name.
TEST_F(StoppedRun, KnowsWhetherAPipeBringsTheSameAgain) {
  const std::string expected = run_in_core();
  MeshFile other = rich_box(11);
  other.point_arrays[0].bytes[0] ^= std::byte{1};
  const std::string mesh = bytes_of(request.input);
  other.write(request.input);
  const std::string other_mesh = bytes_of(request.input);
  ASSERT_EQ(other_mesh.size(), mesh.size());
  std::filesystem::remove(request.input);
  ASSERT_EQ(::mkfifo(request.input.c_str(), 0600), 0);
  const auto feed = [&](const std::string& bytes) {
    return std::jthread([&] { std::ofstream(request.input, std::ios::binary) << bytes; });
  };

  request.performance.on_disk = true;
  auto writer = feed(mesh);
  ASSERT_TRUE(run_until(3, "fusing"));
  request.performance.resume = true;
  writer = feed(other_mesh);
  std::string message;
  EXPECT_EQ(refusal(&message), ErrorCode::kUsage);
  EXPECT_THAT(message, HasSubstr("input checksum"));
  writer = feed(mesh);
  simplify(request);
  EXPECT_EQ(take_output() == expected, true);
}

TEST_F(StoppedRun, MayResumeWhereNothingIs) {
  const std::string expected = run_in_core();
  request.performance.resume = true;
  for (const bool on_disk : {false, true}) {
    request.performance.on_disk = on_disk;
    simplify(request);
    EXPECT_EQ(take_output() == expected, true);
  }
  EXPECT_TRUE(files().empty());
}

// A process that is killed leaves a folder that another one goes on with. The test that dies is
// another process, which gets the name of this one's folder by way of the environment.
TEST_F(StoppedRun, GoesOnAfterAKill) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  constexpr const char* kFolder = "TETFUSION_TEST_KILLED_RUN";
  const auto run_and_die = [&](int round) {
    if (folder.path() != std::getenv(kFolder)) std::filesystem::remove_all(folder.path());
    SimplifyRequest dying = request;
    dying.input = std::string(std::getenv(kFolder)) + "/in.vtu";
    dying.output = std::string(std::getenv(kFolder)) + "/out.vtu";
    std::atomic<int> rounds{0};
    RunContext context;
    context.progress = [&](std::string_view phase, double) {
      if (phase == "fusing" && ++rounds == round) std::raise(SIGKILL);
    };
    simplify(dying, context);
  };
  if (std::getenv(kFolder) == nullptr) setenv(kFolder, folder.path().c_str(), 1);
  const std::string expected = run_in_core();
  request.performance.on_disk = true;
  EXPECT_EXIT(run_and_die(3), ::testing::KilledBySignal(SIGKILL), "");
  EXPECT_EQ(files(), std::set<std::string>{"out.vtu.tetfusion"});
  request.performance.resume = true;
  EXPECT_EXIT(run_and_die(3), ::testing::KilledBySignal(SIGKILL), "");
  EXPECT_EQ(files(), std::set<std::string>{"out.vtu.tetfusion"});
  const SimplifyReport report = simplify(request);
  EXPECT_GT(report.rounds.size(), 4u);
  EXPECT_EQ(take_output() == expected, true);
  EXPECT_TRUE(files().empty());
  unsetenv(kFolder);
}

TEST_F(StoppedRun, IsTalkedOfByOneThatHasNoUseForIt) {
  request.performance.on_disk = true;
  ASSERT_TRUE(run_until(3, "fusing"));
  request.performance.on_disk = false;
  std::vector<std::string> notices;
  RunContext context;
  context.notice = [&](std::string_view s) { notices.emplace_back(s); };
  simplify(request, context);
  EXPECT_THAT(notices, ::testing::Contains(HasSubstr(scratch() + " holds the work")));
  EXPECT_TRUE(std::filesystem::exists(scratch()));
}

// A resumed run tells the whole story, not only its own part.
TEST_F(StoppedRun, ReportsAllRounds) {
  const SimplifyReport whole = simplify(request);
  request.performance.on_disk = true;
  ASSERT_TRUE(run_until(4, "fusing"));
  request.performance.resume = true;
  double first = -1, last = 0;
  std::mutex mutex;
  RunContext context;
  std::vector<std::string> notices;
  context.progress = [&](std::string_view phase, double share) {
    const std::lock_guard lock(mutex);
    if (first < 0 && phase == "fusing") first = share;
    last = share;
  };
  context.notice = [&](std::string_view s) { notices.emplace_back(s); };
  const SimplifyReport report = simplify(request, context);
  EXPECT_GT(first, 0.25);
  EXPECT_EQ(last, 1);
  EXPECT_THAT(notices, ::testing::Contains(HasSubstr("going on after")));
  ASSERT_EQ(report.rounds.size(), whole.rounds.size());
  for (std::size_t i = 0; i < whole.rounds.size(); ++i) {
    EXPECT_EQ(report.rounds[i].pass.fused, whole.rounds[i].pass.fused);
    EXPECT_EQ(report.rounds[i].pass.rejected, whole.rounds[i].pass.rejected);
    EXPECT_EQ(report.rounds[i].chunks, whole.rounds[i].chunks);
  }
  EXPECT_EQ(report.input.tets, whole.input.tets);
  EXPECT_EQ(report.input.volume, whole.input.volume);
  EXPECT_EQ(report.output.points, whole.output.points);
  EXPECT_EQ(report.steering, whole.steering);
  EXPECT_EQ(report.regions, whole.regions);
  EXPECT_EQ(report.facts.unused_points, whole.facts.unused_points);
  EXPECT_EQ(report.facts.locked_vertices, whole.facts.locked_vertices);
  EXPECT_EQ(report.stop_sentence(), whole.stop_sentence());
}

}  // namespace
}  // namespace tetfusion
