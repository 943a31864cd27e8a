#include "base/tasks.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <barrier>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "support/scrambled_schedule.h"

namespace tetfusion {
namespace {

TEST(RunTasks, RunsEachTaskOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> runs(100);
    std::atomic<bool> workers_in_range{true};
    run_tasks(runs.size(), threads, [&](std::size_t task, std::size_t worker) {
      ++runs[task];
      if (worker >= static_cast<std::size_t>(threads)) workers_in_range = false;
    });
    for (const auto& r : runs) EXPECT_EQ(r.load(), 1);
    EXPECT_TRUE(workers_in_range.load());
  }
}

TEST(RunTasks, TakesNoTasksAtAll) {
  run_tasks(0, 3, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(RunTasks, ThrowsTheLowestTasksError) {
  for (int repetition = 0; repetition < 20; ++repetition) {
    try {
      run_tasks(8, 4, [](std::size_t task, std::size_t) {
        if (task >= 2) throw std::runtime_error(std::to_string(task));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      // Tasks begin in order, so task 2 has begun before any later one has failed.
      EXPECT_STREQ(e.what(), "2");
    }
  }
}

TEST(RunTasks, PrefersTheReasonToWhatItMadeOthersGiveUp) {
  for (const std::size_t failing : {0u, 1u, 2u}) {
    std::barrier all_began(3);
    try {
      run_tasks(3, 3, [&](std::size_t task, std::size_t) {
        all_began.arrive_and_wait();
        if (task == failing) throw std::runtime_error("the reason");
        throw Abandoned();
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      EXPECT_STREQ(e.what(), "the reason");
    }
  }
  EXPECT_THROW(run_tasks(2, 2, [](std::size_t, std::size_t) { throw Abandoned(); }), Abandoned);
}

TEST(RunTasks, RunsEachTaskOnceInAScrambledOrder) {
  std::vector<std::size_t> in_order, scrambled, again;
  const auto note_in = [](std::vector<std::size_t>* order) {
    run_tasks(50, 1, [&](std::size_t task, std::size_t) { order->push_back(task); });
  };
  note_in(&in_order);
  {
    const testing::ScrambledSchedule schedule(7);
    note_in(&scrambled);
    note_in(&again);
    EXPECT_GT(schedule.moved(), 80u);
  }
  EXPECT_TRUE(std::is_sorted(in_order.begin(), in_order.end()));
  EXPECT_FALSE(std::is_sorted(scrambled.begin(), scrambled.end()));
  EXPECT_EQ(scrambled, again);
  EXPECT_TRUE(std::is_permutation(scrambled.begin(), scrambled.end(), in_order.begin()));
  std::vector<std::size_t> after;
  note_in(&after);
  EXPECT_EQ(after, in_order);
}

// Where OpenMP binds its threads it has bound the first one, too, and others inherit that. The
// child is this same test.
TEST(RunTasks, UsesAllProcessorsThoughOpenMpBindsItsThreads) {
  constexpr const char* kIsChild = "TETFUSION_TEST_PRINTS_PROCESSORS";
  const auto processors = [] {
    cpu_set_t set;
    return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
  };
  if (std::getenv(kIsChild) != nullptr) {
    std::barrier both(2);
    run_tasks(2, 2, [&](std::size_t, std::size_t worker) {
      both.arrive_and_wait();
      if (worker == 1) std::cout << "processors=" << processors() << std::endl;
    });
    return;
  }
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command =
      "OMP_PROC_BIND=true " + std::string(kIsChild) + "=1 '" + self +
      "' --gtest_filter=RunTasks.UsesAllProcessorsThoughOpenMpBindsItsThreads";
  std::FILE* child = ::popen(command.c_str(), "r");
  ASSERT_NE(child, nullptr);
  std::string text;
  std::array<char, 4096> buffer{};
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), child)) > 0;) {
    text.append(buffer.data(), n);
  }
  EXPECT_EQ(::pclose(child), 0);
  EXPECT_NE(text.find("processors=" + std::to_string(processors()) + "\n"), std::string::npos)
      << text;
}

// Whatever the caller's loops use before and after.
TEST(RunTasks, LoopsOfATaskGetItsShareOfTheThreads) {
  const auto threads_of_loops = [] {
    std::atomic<int> threads{0};
#pragma omp parallel
    ++threads;
    return threads.load();
  };
  set_thread_count(5);
  const int before = threads_of_loops();
#ifdef _OPENMP
  ASSERT_EQ(before, 5);
#endif
  for (const auto& [at_once, share] : {std::pair(1, 5), {2, 2}, {5, 1}, {9, 1}}) {
    std::vector<int> seen(10);
    run_tasks_with_loops(seen.size(), at_once,
                         [&](std::size_t task) { seen[task] = threads_of_loops(); });
    EXPECT_EQ(seen, std::vector<int>(seen.size(), before == 5 ? share : before));
    EXPECT_EQ(threads_of_loops(), before);
  }
  set_thread_count(0);
}

TEST(InOrder, HandsOnInOrderWhatComesInAnyOrder) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const testing::ScrambledSchedule schedule(seed);
    std::vector<std::size_t> taken;
    InOrder<std::size_t> join([&](std::size_t task) { taken.push_back(task); });
    run_tasks(200, 4, [&](std::size_t task, std::size_t) { join.put(task, task); });
    ASSERT_EQ(taken.size(), 200u);
    EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
  }
}

TEST(InOrder, WhatCouldNotBeTakenIsNotHandedOnAgain) {
  std::vector<std::string> taken;
  InOrder<std::string> join([&](std::string value) {
    taken.push_back(value);
    if (value == "full") throw std::runtime_error("no room");
  });
  EXPECT_THROW(join.put(0, "full"), std::runtime_error);
  join.put(1, "next");
  EXPECT_EQ(taken, (std::vector<std::string>{"full", "next"}));
}

}  // namespace
}  // namespace tetfusion
