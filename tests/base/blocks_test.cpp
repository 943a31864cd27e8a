#include "base/blocks.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/resources.h"
#include "base/schedule.h"
#include "support/scrambled_schedule.h"

namespace tetfusion {
namespace {

constexpr std::size_t kBlocks = 200;

// Which blocks were done, and whose error came.
struct Outcome {
  std::set<std::size_t> done;
  std::string error;
};

Outcome outcome_of(const std::set<std::size_t>& failing) {
  std::vector<char> begun(kBlocks, 0);
  Outcome out;
  try {
    for_each_block(10 * kBlocks, 10, [&](std::size_t block, std::size_t, std::size_t) {
      begun[block] = 1;
      if (failing.contains(block)) throw std::runtime_error(std::to_string(block));
    });
  } catch (const std::runtime_error& error) {
    out.error = error.what();
  }
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (begun[b] != 0) out.done.insert(b);
  }
  return out;
}

// The last block comes first.
class BackwardSchedule : public Schedule {
 public:
  BackwardSchedule() : before_(replace_schedule(this)) {}
  ~BackwardSchedule() override { replace_schedule(before_); }
  BackwardSchedule(const BackwardSchedule&) = delete;
  BackwardSchedule& operator=(const BackwardSchedule&) = delete;

  std::size_t task(std::size_t turn, std::size_t tasks) override { return tasks - 1 - turn; }

 private:
  Schedule* before_;
};

// As at the start of a large file, of which the rest need not be read.
TEST(Blocks, NothingIsDoneBehindAnError) {
  set_thread_count(1);
  const Outcome out = outcome_of({3});
  set_thread_count(0);
  EXPECT_EQ(out.error, "3");
  EXPECT_EQ(out.done, (std::set<std::size_t>{0, 1, 2, 3}));
}

TEST(Blocks, WhatComesBeforeAnErrorIsDone) {
  const BackwardSchedule backward;
  const Outcome out = outcome_of({60, 120, 180});
  EXPECT_EQ(out.error, "60");
  for (std::size_t b = 0; b <= 60; ++b) EXPECT_TRUE(out.done.contains(b)) << b;
}

TEST(Blocks, TheLowestErrorIsThrownInAnyOrder) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const testing::ScrambledSchedule scrambled(seed);
    EXPECT_EQ(outcome_of({seed, seed + 1, 100, kBlocks - 1}).error, std::to_string(seed));
  }
}

}  // namespace
}  // namespace tetfusion
