// What a dry run says of a run, beside what the run then does.
#include "driver/estimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/resources.h"
#include "driver/run_plan.h"
#include "driver/simplify.h"
#include "generate/generate.h"
#include "io/files/file_system.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using testing::TempDir;

class Estimate : public ::testing::Test {
 protected:
  Estimate() {
    request.input = folder.file("in.vtu");
    request.output = folder.file("out.vtu");
  }
  ~Estimate() override { set_thread_count(0); }

  void generate(LatticeKind kind, std::uint64_t tets, bool shuffle = false) {
    GenerateOptions options;
    options.kind = kind;
    options.tets = tets;
    options.jitter = 0.3;
    options.shuffle = shuffle;
    generate_mesh(options, request.input);
  }
  // Without a goal the run goes as far as can be.
  double reached() {
    SimplifyRequest far = request;
    far.behaviour.reduction.reset();
    return simplify(far).reduction();
  }
  RunEstimate estimate(std::uint64_t sample_tets) {
    return plan_run(request, {}, sample_tets).estimate;
  }
  void expect_nothing_written() const {
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      EXPECT_EQ(entry.path(), request.input);
    }
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request;
};

TEST_F(Estimate, OfASmallMeshIsWhatItsRunDoes) {
  generate(LatticeKind::kBcc, 6000);
  for (const Method method : {Method::kFuse, Method::kTetFuse}) {
    request.behaviour.method = method;
    const RunEstimate e = estimate(kSampleTets);
    EXPECT_TRUE(e.is_whole());
    EXPECT_FALSE(e.goal);
    EXPECT_GT(e.reduction, 0.1);
    expect_nothing_written();
    EXPECT_DOUBLE_EQ(e.reduction, reached());
    std::filesystem::remove(request.output);
  }
}

// A tenth of the mesh is tried out.
TEST_F(Estimate, OfAPartIsNearWhatTheWholeReaches) {
  for (const LatticeKind kind : {LatticeKind::kFive, LatticeKind::kBcc}) {
    for (const Method method : {Method::kFuse, Method::kTetFuse}) {
      SCOPED_TRACE(static_cast<int>(kind) * 10 + static_cast<int>(method));
      generate(kind, 80'000, kind == LatticeKind::kBcc);
      request.behaviour.method = method;
      request.behaviour.chunk_tets = 20'000;
      const RunEstimate e = estimate(8000);
      expect_nothing_written();
      EXPECT_GT(e.sample_tets, 4000u);
      EXPECT_LT(e.sample_tets, 16'000u);
      const SimplifyReport report = simplify(request);
      std::filesystem::remove(request.output);
      EXPECT_EQ(e.tets, report.input.tets);
      EXPECT_NEAR(e.reduction, report.reduction(), 0.1);
      EXPECT_LT(1 - e.reduction, 2 * (1 - report.reduction()));
      EXPECT_GT(1 - e.reduction, (1 - report.reduction()) / 2);
      EXPECT_GT(e.seconds, 0);
      EXPECT_LT(e.seconds, 600);
      EXPECT_GT(e.sample_seconds, 0);
    }
  }
}

// What the cut keeps of the sample is three times as much as would be left.
TEST_F(Estimate, OfAPartWhoseBoundaryMovesIsNotWhatItsCutKeeps) {
  for (const LatticeKind kind : {LatticeKind::kFive, LatticeKind::kBcc}) {
    SCOPED_TRACE(static_cast<int>(kind));
    generate(kind, 80'000);
    request.behaviour.boundary = Boundary::kPlanar;
    request.behaviour.regions.emplace();
    request.behaviour.max_error = 0.02;
    request.behaviour.reduction = 0.5;
    const RunEstimate e = estimate(16'000);
    EXPECT_TRUE(e.is_rough);
    EXPECT_EQ(e.reaches_goal(), true);
    const double left = 1 - reached();
    EXPECT_LT(e.low_reduction(), 1 - left);
    std::filesystem::remove(request.output);
    EXPECT_LT(1 - e.reduction, 4 * left);
    EXPECT_GT(1 - e.reduction, left / 4);
  }
}

TEST_F(Estimate, NeverCallsAGoalOutOfReachWhereTheBoundaryMoves) {
  generate(LatticeKind::kFive, 30'000);
  request.behaviour.boundary = Boundary::kPlanar;
  request.behaviour.reduction = 0.9999;
  EXPECT_EQ(estimate(5000).reaches_goal(), std::nullopt);
  EXPECT_EQ(estimate(kSampleTets).reaches_goal(), false);  // all of it was tried
}

TEST_F(Estimate, KnowsWhetherTheGoalCanBeReached) {
  generate(LatticeKind::kFive, 30'000);
  for (const double goal : {0.3, 0.999}) {
    request.behaviour.reduction = goal;
    for (const std::uint64_t sample : {std::uint64_t{5000}, kSampleTets}) {
      const RunEstimate e = estimate(sample);
      ASSERT_TRUE(e.goal);
      EXPECT_NEAR(*e.goal, goal, 1e-3);
      EXPECT_EQ(e.reaches_goal(), goal < 0.5);
    }
  }
  // Less time to a goal that is near than to one that is not, as far as rounds count.
  EXPECT_LE(estimate(kSampleTets).sample_seconds, 600);
}

TEST_F(Estimate, DoesNotDependOnThreads) {
  generate(LatticeKind::kFive, 30'000);
  request.behaviour.reduction = 0.5;
  request.performance.threads = 1;
  const RunEstimate one = estimate(4000);
  request.performance.threads = 3;
  const RunEstimate three = estimate(4000);
  EXPECT_EQ(one.reduction, three.reduction);
  EXPECT_EQ(one.sample_tets, three.sample_tets);
  EXPECT_EQ(one.boundary_share, three.boundary_share);
  request.behaviour.boundary = Boundary::kPlanar;
  const double moves = estimate(4000).reduction;
  request.performance.threads = 1;
  EXPECT_EQ(estimate(4000).reduction, moves);
}

// Cells of lower dimension, unused points, regions: the sample is a mesh like any other.
TEST_F(Estimate, OfAMeshWithAllThatAMeshCanHave) {
  testing::rich_box(12).write(request.input);
  request.behaviour.reduction = 0.3;
  const RunPlan plan = plan_run(request, {}, 2000);
  EXPECT_GT(plan.estimate.reduction, 0);
  EXPECT_LT(plan.estimate.reduction, 1);
  EXPECT_GT(plan.estimate.boundary_share, 0.1);
  EXPECT_LT(plan.estimate.sample_tets, plan.estimate.tets);
  const std::string json = to_json(plan);
  for (const char* key : {"\"reduction\"", "\"reaches_goal\": ", "\"seconds\"", "\"sample_tets\"",
                          "\"boundary_points_share\"", "\"scratch_bytes\": 0"}) {
    EXPECT_THAT(json, HasSubstr(key));
  }
}

// They lie where the sample would be taken.
TEST_F(Estimate, OfAMeshWithMostPointsUnused) {
  testing::MeshFile file;
  file.geometry = testing::corner_of_a_cube(32);
  file.write(request.input);
  request.behaviour.reduction = 0.3;
  const RunEstimate e = estimate(4000);
  EXPECT_EQ(e.tets, 5u * 16 * 16 * 16);
  EXPECT_GT(e.sample_tets, 2000u);
  EXPECT_LT(e.sample_tets, 8000u);
  EXPECT_GT(e.reduction, 0.1);
}

// There is no place for the mesh on disk.
TEST_F(Estimate, RefusesThePlaceThatTheRunWouldRefuse) {
  generate(LatticeKind::kFive, 3000);
  request.behaviour.reduction = 0.5;
  const SimplifyRequest plain = request;
  const auto error_of = [&](auto run) {
    try {
      run(request);
    } catch (const Error& e) {
      return std::pair(e.code(), std::string(e.what()));
    }
    ADD_FAILURE() << "was not refused";
    return std::pair(ErrorCode::kBroken, std::string());
  };
  const auto expect_refused = [&](const std::string& part) {
    const auto planned = error_of([](const SimplifyRequest& r) { plan_run(r); });
    const auto ran = error_of([](const SimplifyRequest& r) { simplify(r); });
    EXPECT_EQ(planned, ran);
    EXPECT_THAT(planned.second, HasSubstr(part));
    request = plain;
  };
  request.output = "-";
  request.performance.on_disk = true;
  expect_refused("beside standard output there is no folder");

  const std::string theirs = folder.file("theirs");
  std::filesystem::create_directory(theirs);
  std::ofstream(theirs + "/thesis.txt") << "years of work";
  for (const bool on_disk : {false, true}) {
    request.performance.on_disk = on_disk;
    request.performance.scratch = theirs;
    expect_refused("thesis.txt");
  }
  std::filesystem::remove_all(theirs);

  class FullDisk : public FileSystem {
   public:
    FullDisk() : before_(replace_file_system(this)) {}
    ~FullDisk() override { replace_file_system(before_); }
    int fstatvfs(int fd, struct statvfs* status) override {
      const int result = FileSystem::fstatvfs(fd, status);
      status->f_bavail = 1;
      return result;
    }

   private:
    FileSystem* before_;
  };
  const FullDisk disk;
  request.performance.on_disk = true;
  expect_refused("the disk has room for");
  expect_nothing_written();
}

// A mesh that would fit into memory is on disk, too, if what is left of it lies there.
TEST_F(Estimate, IsOfARunThatGoesOnFromWhatIsLeft) {
  generate(LatticeKind::kFive, 3000);
  request.behaviour.reduction = 0.5;
  request.performance.resume = true;
  EXPECT_FALSE(plan_run(request).on_disk);
  std::filesystem::create_directory(request.output + ".tetfusion");
  EXPECT_TRUE(plan_run(request).on_disk);
  EXPECT_TRUE(std::filesystem::is_empty(request.output + ".tetfusion"));
}

TEST_F(Estimate, ThrowsWhatTheRunWouldThrow) {
  testing::MeshFile file;
  file.geometry = testing::five_split_cube(4);
  file.write(request.input);  // no field
  try {
    plan_run(request);
    FAIL() << "was not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUsage);
    EXPECT_THAT(e.what(), HasSubstr("--reduction"));
  }
}

}  // namespace
}  // namespace tetfusion
