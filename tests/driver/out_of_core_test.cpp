// Runs with the mesh in memory and on disk, to the end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/resources.h"
#include "driver/rounds/memory_plan.h"
#include "driver/simplify.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/out_of_core_run.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::rich_box;

class OutOfCore : public testing::OutOfCoreRun {};

TEST_F(OutOfCore, TheBytesDoNotDependOnThreadsAndMemory) {
  for (const bool has_goal : {false, true}) {
    if (has_goal) request.behaviour.reduction = 0.2;
    request.encoding = has_goal ? Encoding::kZlib : Encoding::kRaw;
    expect_same_bytes_everywhere();
  }
}

TEST_F(OutOfCore, NorDoThoseOfFuse) {
  for (const bool has_goal : {false, true}) {
    fuse(has_goal ? std::optional(0.5) : std::nullopt);
    expect_same_bytes_everywhere();
  }
}

// Points that are no vertices any more go from chunk to chunk.
TEST_F(OutOfCore, NorDoThoseOfABoundAtPoints) {
  for (const bool has_goal : {false, true}) {
    fuse(has_goal ? std::optional(0.3) : std::nullopt);
    request.behaviour.max_rms.reset();
    request.behaviour.max_error = 0.05;
    expect_same_bytes_everywhere();
  }
}

// Chunks so small that many have as many tetrahedra as their worker has left of the last one.
TEST_F(OutOfCore, NorDoThoseOfABoundAtPointsInManySmallChunks) {
  rich_box(10).write(request.input);
  fuse(std::nullopt);
  request.behaviour.max_rms.reset();
  for (const double error : {0.02, 0.05}) {
    for (const std::uint64_t chunk_tets : {40, 60}) {
      request.behaviour.max_error = error;
      request.behaviour.chunk_tets = chunk_tets;
      std::string expected;
      for (const int threads : {1, 2, 3}) {
        request.performance.threads = threads;
        simplify(request);
        const std::string found = testing::bytes_of(request.output);
        if (threads == 1) expected = found;
        EXPECT_TRUE(found == expected) << error << ", " << chunk_tets << ", " << threads;
      }
    }
  }
}

// Two fields, one of them a vector, in a mesh of floats: quadrics are rows of another length.
TEST_F(OutOfCore, NorDoThoseOfFuseWithSeveralFields) {
  MeshFile file = rich_box(10);
  file.geometry = testing::to_float(file.geometry);
  file.point_arrays.push_back(testing::make_array<float>(
      "v", file.points(), 3, [](auto i, auto k) { return std::sin(0.01 * double(i * (k + 1))); }));
  file.write(request.input);
  request.behaviour.arrays = {"f", "v"};
  fuse(0.4);
  expect_same_bytes_everywhere();
}

TEST_F(OutOfCore, NorDoThoseOfABoundaryThatMoves) {
  fuse(0.6);
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.01;
  expect_same_bytes_everywhere();
}

TEST_F(OutOfCore, TheMemoryDecidesWhereTheMeshIs) {
  const std::string expected = run_in_core();
  const MemoryNeeds needs = needs_with(1);
  request.performance.threads = 1;
  request.performance.memory = needs.in_core;
  EXPECT_EQ(simplify(request).scratch_bytes, 0u);
  EXPECT_EQ(take_output() == expected, true);
  for (const std::uint64_t memory : {needs.in_core - 1, needs.out_of_core}) {
    request.performance.memory = memory;
    EXPECT_GT(simplify(request).scratch_bytes, 0u);
    EXPECT_EQ(take_output() == expected, true);
  }
  request.performance.memory = needs.out_of_core - 1;
  std::string message;
  EXPECT_EQ(refusal(&message), ErrorCode::kMemory);
  EXPECT_THAT(message, HasSubstr("--memory"));
  EXPECT_TRUE(files().empty());
}

TEST_F(OutOfCore, TheMemoryDecidesHowManyThreadsThereAre) {
  const std::string expected = run_in_core();
  request.performance.threads = 64;
  const auto run_with = [&](std::uint64_t memory) {
    request.performance.memory = memory;
    std::string said;
    RunContext context;
    context.notice = [&](std::string_view notice) { said += notice; };
    const SimplifyReport report = simplify(request, context);
    EXPECT_EQ(said.find(" of 64 threads") == std::string::npos, report.threads == 64) << said;
    EXPECT_EQ(take_output() == expected, true);
    return report.threads;
  };
  EXPECT_EQ(run_with(needs_with(64).out_of_core), 64);
  EXPECT_EQ(run_with(needs_with(64).out_of_core - 1), 63);
  EXPECT_EQ(run_with(needs_with(5).out_of_core), 5);
  EXPECT_EQ(run_with(needs_with(1).out_of_core), 1);
}

// Else the end of a run, or of one that is stopped, would have to wait for the disk.
TEST_F(OutOfCore, NothingIsSyncedWhereNobodyGoesOn) {
  const std::string expected = run_in_core();
  request.performance.on_disk = true;
  request.performance.keep_work = false;
  std::atomic<bool> in_rounds{false};
  std::atomic<int> syncs{0};
  RunContext context;
  context.progress = [&](std::string_view phase, double) { in_rounds = phase == "fusing"; };
  testing::FaultyFileSystem system;
  system.before([&](testing::FaultyFileSystem::Call call) {
    if (in_rounds && call == testing::FaultyFileSystem::Call::kSync) ++syncs;
  });
  EXPECT_GT(simplify(request, context).rounds.size(), 2u);
  EXPECT_EQ(syncs, 0);
  EXPECT_TRUE(take_output() == expected);
}

TEST_F(OutOfCore, TheScratchFolderMayBeElsewhere) {
  request.performance.on_disk = true;
  request.performance.scratch = folder.file("elsewhere");
  const auto message = run_until(3, "fusing");
  ASSERT_TRUE(message);
  EXPECT_THAT(*message, HasSubstr(request.performance.scratch));
  EXPECT_EQ(files(), std::set<std::string>{"elsewhere"});
  request.performance.resume = true;
  simplify(request);
  EXPECT_EQ(files(), std::set<std::string>{"out.vtu"});
}

}  // namespace
}  // namespace tetfusion
