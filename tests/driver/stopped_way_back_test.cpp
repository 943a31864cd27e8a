// Runs that are stopped while they write the way back.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "driver/simplify.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::TempDir;

class StoppedWayBack : public ::testing::Test {
 protected:
  StoppedWayBack() {
    request.behaviour.reduction = 0.5;
    request.behaviour.chunk_tets = 700;
    request.progressive = folder.file("run.tfp");
    request.performance.threads = 1;
    testing::rich_box(11).write(request.input);
  }
  ~StoppedWayBack() override { set_thread_count(0); }

  // What lies in the folder but for the input.
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      if (entry.path() != request.input) names.insert(entry.path().filename().string());
    }
    return names;
  }
  // Of writing it.
  std::vector<double> shares() const {
    std::vector<double> told;
    RunContext context;
    context.progress = [&](std::string_view phase, double share) {
      if (phase == kPhase) told.push_back(share);
    };
    simplify(request, context);
    return told;
  }
  // Stops at the given of these reports, and expects that no other one follows.
  void stop_at(std::size_t report) const {
    std::atomic<bool> cancelled{false};
    std::size_t in_phase = 0, after = 0;
    RunContext context;
    context.cancelled = &cancelled;
    context.progress = [&](std::string_view phase, double) {
      if (cancelled) ++after;
      if (phase == kPhase && ++in_phase == report) cancelled = true;
    };
    try {
      simplify(request, context);
      ADD_FAILURE() << "was not stopped at report " << report;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kInterrupted) << e.what();
    }
    EXPECT_EQ(after, 0u) << "behind report " << report;
  }

  static constexpr std::string_view kPhase = "way back";
  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
};

TEST_F(StoppedWayBack, InMemoryLeavesNothing) {
  const std::vector<double> told = shares();
  ASSERT_GT(told.size(), 40u);  // a chunk, a range, or a percent of the fusions each
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(files(), (std::set<std::string>{"out.vtu", "run.tfp"}));
  std::filesystem::remove(request.output);
  std::filesystem::remove(request.progressive);
  for (std::size_t report = 1; report <= told.size(); report += report < 20 ? 1 : 20) {
    stop_at(report);
    EXPECT_TRUE(files().empty());
  }
  stop_at(told.size());
  EXPECT_TRUE(files().empty());
}

TEST_F(StoppedWayBack, IsGoneOnWith) {
  const std::size_t reports = shares().size();
  const std::string expected = bytes_of(request.progressive);
  for (const std::size_t report : {std::size_t{1}, reports / 2, reports}) {
    std::filesystem::remove(request.output);
    std::filesystem::remove(request.progressive);
    request.performance.on_disk = true;
    request.performance.resume = false;
    stop_at(report);
    EXPECT_EQ(files(), std::set<std::string>{"out.vtu.tetfusion"});
    request.performance.resume = true;
    simplify(request);
    EXPECT_EQ(files(), (std::set<std::string>{"out.vtu", "run.tfp"}));
    EXPECT_TRUE(bytes_of(request.progressive) == expected) << "stopped at report " << report;
  }
}

}  // namespace
}  // namespace tetfusion
