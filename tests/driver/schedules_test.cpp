// The order in which threads get their work, and how long each takes, changes no byte.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <tuple>

#include "base/resources.h"
#include "driver/simplify.h"
#include "support/import.h"
#include "support/mesh_file.h"
#include "support/scrambled_schedule.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::Import;
using testing::rich_box;
using testing::ScrambledSchedule;
using testing::TempDir;

constexpr std::uint64_t kSchedules = 10;

class Schedules : public ::testing::TestWithParam<std::tuple<Method, bool>> {
 protected:
  Schedules() {
    request.input = folder.file("in.vtu");
    request.behaviour.method = std::get<0>(GetParam());
    request.behaviour.scalar_tolerance = {0.2};
    request.behaviour.reduction = 0.4;
    request.behaviour.chunk_tets = 700;
    rich_box(11).write(request.input);
  }
  ~Schedules() override { set_thread_count(0); }

  // The bytes of all files that a run leaves, in the order of their names.
  std::string run() {
    simplify(request);
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
      if (entry.is_regular_file() && entry.path() != request.input) {
        files[entry.path().string()] = bytes_of(entry.path().string());
      }
    }
    std::string all;
    for (const auto& [name, bytes] : files) all += name + bytes;
    std::filesystem::remove_all(folder.file("out_pieces"));
    std::filesystem::remove(request.output);
    return all;
  }
  void expect_same_bytes() {
    request.performance = {};
    request.performance.threads = 1;
    const std::string expected = run();
    ASSERT_GT(expected.size(), 10'000u);
    request.performance.on_disk = std::get<1>(GetParam());
    for (std::uint64_t seed = 1; seed <= kSchedules; ++seed) {
      request.performance.threads = 2 + static_cast<int>(seed % 3);
      const ScrambledSchedule scrambled(seed);
      EXPECT_EQ(run() == expected, true) << "schedule " << seed;
      EXPECT_GT(scrambled.moved(), 20u);
    }
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request;
};

TEST_P(Schedules, ChangeNoByteOfAFile) {
  request.output = folder.file("out.vtu");
  expect_same_bytes();
}

TEST_P(Schedules, ChangeNoByteOfAnEncodedFile) {
  request.output = folder.file("out.vtu");
  request.encoding = Encoding::kZlib;
  request.behaviour.reduction.reset();
  if (request.behaviour.method == Method::kFuse) request.behaviour.max_rms = 0.01;
  expect_same_bytes();
}

TEST_P(Schedules, ChangeNoByteOfPieces) {
  request.output = folder.file("out.pvtu");
  request.pieces = 3;
  expect_same_bytes();
}

// In the last rounds before a goal chunks take what is left in turn.
TEST_P(Schedules, ChangeNoByteNearAGoal) {
  request.output = folder.file("out.vtu");
  request.behaviour.reduction = 0.3;
  expect_same_bytes();
}

INSTANTIATE_TEST_SUITE_P(Methods, Schedules,
                         ::testing::Combine(::testing::Values(Method::kTetFuse, Method::kFuse),
                                            ::testing::Bool()));

// Windows that come in any order, of any size.
TEST(ScheduleOfImport, ChangesNoChunk) {
  const TempDir folder;
  const std::string path = folder.file("in.vtu");
  rich_box(9).write(path);
  const auto expected = Import<double>(path, {.chunk_tets = 400}).chunks();
  ASSERT_GT(expected.size(), 5u);
  set_thread_count(4);
  for (std::uint64_t seed = 1; seed <= kSchedules; ++seed) {
    const ScrambledSchedule scrambled(seed);
    const Import<double> import(
        path, {.chunk_tets = 400, .on_disk = seed % 2 == 0, .window = 20 * seed * seed});
    const auto chunks = import.chunks();
    ASSERT_EQ(chunks.size(), expected.size());
    for (std::size_t c = 0; c < chunks.size(); ++c) {
      EXPECT_EQ(chunks[c].tets, expected[c].tets) << seed;
      EXPECT_EQ(chunks[c].point_ids, expected[c].point_ids) << seed;
      EXPECT_EQ(chunks[c].marks, expected[c].marks) << seed;
      EXPECT_EQ(chunks[c].steering, expected[c].steering) << seed;
    }
    EXPECT_EQ(import.imported.lower.cells.connectivity.size(),
              import.imported.lower.cells.offsets.back());
    EXPECT_GT(scrambled.moved(), 5u);
    import.scratch->remove();
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace tetfusion
