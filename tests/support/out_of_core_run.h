// A run that may have its mesh in memory or on disk, and what it leaves.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "driver/rounds/memory_plan.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_stream.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

class OutOfCoreRun : public ::testing::Test {
 protected:
  OutOfCoreRun() {
    request.input = folder.file("in.vtu");
    request.output = folder.file("out.vtu");
    request.behaviour.method = Method::kTetFuse;
    request.behaviour.scalar_tolerance = {0.2};
    request.behaviour.chunk_tets = 700;
    rich_box(11).write(request.input);
  }
  ~OutOfCoreRun() override { set_thread_count(0); }

  std::string scratch() const { return request.output + ".tetfusion"; }
  // What lies in the folder but for the input.
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      if (entry.path() != request.input) names.insert(entry.path().filename().string());
    }
    return names;
  }
  MemoryNeeds needs_with(int threads) const {
    const auto source = open_mesh(request.input);
    return estimate_needs(source->description(), {.vertex = sizeof(double)},
                          request.behaviour.chunk_tets, threads,
                          {0, source->stream()->lower_cells()});
  }
  // The output's bytes; the output is removed.
  std::string take_output() {
    std::string bytes = bytes_of(request.output);
    std::filesystem::remove(request.output);
    return bytes;
  }
  std::string run_in_core() {
    SimplifyRequest in_core = request;
    in_core.performance = {};
    simplify(in_core);
    return take_output();
  }
  // Stops at the given call of progress (of that phase); gives the message, or nothing if the run
  // ended before.
  std::optional<std::string> run_until(int report, std::string_view phase = {}) {
    std::atomic<bool> cancelled{false};
    std::atomic<int> reports{0};
    RunContext context;
    context.cancelled = &cancelled;
    context.progress = [&](std::string_view now, double) {
      if ((phase.empty() || now == phase) && ++reports == report) cancelled = true;
    };
    try {
      simplify(request, context);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kInterrupted) << e.what();
      return e.what();
    }
    return std::nullopt;
  }
  // Where to stop: at every report but of those of writing, which is one for each percent.
  std::vector<int> stops() {
    std::vector<int> out;
    int report = 0, in_row = 0;
    std::mutex mutex;
    RunContext context;
    context.progress = [&](std::string_view phase, double) {
      const std::lock_guard lock(mutex);
      ++report;
      in_row = phase == "writing" ? in_row + 1 : 0;
      if (in_row < 3 || in_row % 40 == 0) out.push_back(report);
    };
    simplify(request, context);
    out.pop_back();  // the last one comes when all is done
    return out;
  }
  void expect_same_bytes_everywhere() {
    const std::string expected = run_in_core();
    ASSERT_FALSE(expected.empty());
    for (const int threads : {1, 2, 3, 8}) {
      for (const bool on_disk : {false, true}) {
        request.performance.threads = threads;
        request.performance.on_disk = on_disk;
        const SimplifyReport report = simplify(request);
        EXPECT_GE(report.rounds.front().chunks, 8u);
        EXPECT_EQ(report.scratch_bytes > 0, on_disk);
        EXPECT_EQ(files(), std::set<std::string>{"out.vtu"});
        EXPECT_EQ(take_output() == expected, true) << threads << " threads, on disk: " << on_disk;
      }
    }
  }
  // By the method that takes the cheapest first; `reduction` is the goal, or none.
  void fuse(std::optional<double> reduction) {
    request.behaviour.method = Method::kFuse;
    request.behaviour.reduction = reduction;
    if (!reduction) request.behaviour.max_rms = 0.01;
  }
  ErrorCode refusal(std::string* message = nullptr) {
    try {
      simplify(request);
    } catch (const Error& e) {
      if (message != nullptr) *message = e.what();
      return e.code();
    }
    ADD_FAILURE() << "was not refused";
    return {};
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request;
};

}  // namespace tetfusion::testing
