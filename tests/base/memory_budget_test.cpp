#include "base/memory_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <chrono>
#include <cstdint>
#include <future>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/tasks.h"
#include "support/units.h"

namespace tetfusion {
namespace {

using namespace std::chrono_literals;
using Reservation = MemoryBudget::Reservation;
using ::testing::AllOf;
using ::testing::HasSubstr;

using testing::kMiB;
// Long enough for a thread to have begun to wait; a test passes on a slower machine, too.
constexpr auto kMoment = 30ms;

template <class Function>
std::string memory_error(const Function& function) {
  try {
    function();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kMemory);
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

template <class T>
bool waits(const std::future<T>& future) {
  return future.wait_for(kMoment) == std::future_status::timeout;
}

TEST(MemoryBudget, CountsWhatIsReserved) {
  MemoryBudget budget(100);
  Reservation a = budget.reserve(60, "a");
  EXPECT_EQ(a.bytes(), 60u);
  EXPECT_EQ(budget.used(), 60u);
  {
    const Reservation b = budget.wait_for(40, "b");
    EXPECT_EQ(budget.free(), 0u);
  }
  EXPECT_EQ(budget.free(), 40u);
  a.release();
  a.release();
  EXPECT_EQ(budget.used(), 0u);
  EXPECT_EQ(budget.peak(), 100u);
  EXPECT_EQ(budget.total(), 100u);
}

TEST(MemoryBudget, ReservationsMove) {
  MemoryBudget budget(100);
  Reservation a = budget.reserve(60, "a");
  Reservation b = std::move(a);
  EXPECT_EQ(b.bytes(), 60u);
  EXPECT_EQ(budget.used(), 60u);
  b = budget.wait_for(30, "c");  // both are out for a moment
  EXPECT_EQ(budget.used(), 30u);
  EXPECT_EQ(budget.peak(), 90u);
  Reservation& itself = b;
  b = std::move(itself);
  EXPECT_EQ(budget.used(), 30u);
  b = Reservation();
  EXPECT_EQ(budget.used(), 0u);
}

TEST(MemoryBudget, SaysWhatIsNeeded) {
  MemoryBudget budget(100 * kMiB);
  const Reservation table = budget.reserve(30 * kMiB, "the table");
  const std::string text = memory_error([&] { budget.reserve(71 * kMiB + 1, "the output"); });
  EXPECT_THAT(text, AllOf(HasSubstr("the output needs 71.0 MiB beside 30.0 MiB: 101.0 MiB in all"),
                          HasSubstr("budget of 100.0 MiB"), HasSubstr("--memory 102M or more")));
  EXPECT_THAT(memory_error([&] { budget.wait_for(71 * kMiB, "a chunk"); }),
              HasSubstr("--memory 101M or more"));
  EXPECT_EQ(budget.used(), 30 * kMiB);
}

TEST(MemoryBudget, RefusesSumsBeyondAllMemory) {
  MemoryBudget budget(100);
  const Reservation a = budget.reserve(60, "a");
  memory_error([&] { budget.reserve(UINT64_MAX, "b"); });
  memory_error([&] { budget.wait_for(UINT64_MAX - 10, "b"); });
  EXPECT_EQ(budget.used(), 60u);
}

TEST(MemoryBudget, ReserveDoesNotWait) {
  MemoryBudget budget(100);
  const Reservation passing = budget.wait_for(60, "a chunk");
  memory_error([&] { budget.reserve(50, "a table"); });
}

TEST(MemoryBudget, WaitsUntilThereIsRoom) {
  MemoryBudget budget(100);
  const Reservation a = budget.wait_for(50, "a");
  Reservation c = budget.wait_for(20, "c"), d = budget.wait_for(10, "d");
  auto b = std::async(std::launch::async, [&] { return budget.wait_for(50, "b"); });
  EXPECT_TRUE(waits(b));
  d.release();
  EXPECT_TRUE(waits(b));
  c.release();
  EXPECT_EQ(b.get().bytes(), 50u);
  EXPECT_EQ(budget.peak(), 100u);
}

TEST(MemoryBudget, ALargeRequestIsNotPassedBySmallOnes) {
  MemoryBudget budget(100);
  Reservation a = budget.wait_for(60, "a");
  auto large = std::async(std::launch::async, [&] { return budget.wait_for(90, "large"); });
  ASSERT_TRUE(waits(large));
  auto small = std::async(std::launch::async, [&] { return budget.wait_for(20, "small"); });
  EXPECT_TRUE(waits(small)) << "there is room, but it was not its turn";
  a.release();
  Reservation held = large.get();
  EXPECT_EQ(held.bytes(), 90u);
  EXPECT_TRUE(waits(small));
  held.release();
  EXPECT_EQ(small.get().bytes(), 20u);
}

TEST(MemoryBudget, WhoCanNeverHaveItIsToldWhenThatIsSo) {
  MemoryBudget budget(100);
  Reservation a = budget.wait_for(60, "a");
  auto b = std::async(std::launch::async, [&] { return budget.wait_for(80, "b"); });
  auto c = std::async(std::launch::async, [&] {
    std::this_thread::sleep_for(kMoment / 2);
    return budget.wait_for(40, "c");
  });
  ASSERT_TRUE(waits(b));
  const Reservation table = budget.reserve(30, "a table");
  memory_error([&] { b.get(); });
  a.release();
  EXPECT_EQ(c.get().bytes(), 40u) << "who gave up stands in the way";
}

TEST(MemoryBudget, AFailingWorkerIsWhatIsReported) {
  MemoryBudget budget(10);
  std::barrier both_began(2);
  try {
    run_tasks(2, 2, [&](std::size_t task, std::size_t) {
      Reservation mine;
      if (task == 1) mine = budget.wait_for(10, "task 1");
      both_began.arrive_and_wait();
      if (task == 0) mine = budget.wait_for(10, "task 0");
      throw Error(ErrorCode::kIo, "the disk is full");
    });
    FAIL() << "nothing was thrown";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "the disk is full");
  }
  EXPECT_EQ(budget.used(), 0u);
}

TEST(MemoryBudget, ManyThreadsStayWithin) {
  constexpr std::uint64_t kTotal = 1000;
  MemoryBudget budget(kTotal);
  std::atomic<std::uint64_t> out{0};
  std::atomic<std::uint64_t> most{0};
  run_tasks(2000, 8, [&](std::size_t task, std::size_t) {
    const std::uint64_t bytes = task * 7919 % kTotal + 1;
    Reservation mine = budget.wait_for(bytes, "a task");
    const std::uint64_t now = out += bytes;
    for (std::uint64_t m = most; m < now && !most.compare_exchange_weak(m, now);) {
    }
    if (task % 16 == 0) std::this_thread::yield();
    out -= bytes;
  });
  EXPECT_LE(most, kTotal);
  EXPECT_LE(budget.peak(), kTotal);
  EXPECT_GE(budget.peak(), most);
  EXPECT_EQ(budget.used(), 0u);
}

}  // namespace
}  // namespace tetfusion
