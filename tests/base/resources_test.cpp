#include "base/resources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "base/tasks.h"
#include "support/temp_dir.h"
#include "support/units.h"

namespace tetfusion {
namespace {

using testing::kMiB;

// A root folder with the kernel's files of a machine of 1000 MiB.
class Machine {
 public:
  Machine() { put("/proc/meminfo", "MemTotal:        1024000 kB\nMemFree:  17 kB\n"); }

  void put(const std::string& path, const std::string& text) {
    const std::filesystem::path file = root() + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void mount(const std::string& mounts, const std::string& groups) {
    put("/proc/self/mountinfo", "22 1 0:20 / /proc rw - proc proc rw\n" + mounts);
    put("/proc/self/cgroup", groups);
  }
  std::string root() const { return dir_.path().string(); }
  std::uint64_t limit_mib() const { return memory_limit(root()) / kMiB; }
  int processors() const { return available_processors(root()); }

 private:
  testing::TempDir dir_;
};

constexpr const char* kVersion2 =
    "31 22 0:28 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw\n";
constexpr const char* kVersion1 =
    "34 31 0:31 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n"
    "35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n";

TEST(MemoryLimit, IsTheMachinesMemory) {
  Machine machine;
  EXPECT_EQ(machine.limit_mib(), 1000u);
  machine.mount(kVersion2, "0::/user.slice/a\n");
  EXPECT_EQ(machine.limit_mib(), 1000u) << "no group has a limit";
}

TEST(MemoryLimit, IsTheSmallestUpTheTree) {
  Machine machine;
  machine.mount(kVersion2, "0::/user.slice/a/b\n");
  machine.put("/sys/fs/cgroup/user.slice/a/b/memory.max", "max\n");
  EXPECT_EQ(machine.limit_mib(), 1000u);
  machine.put("/sys/fs/cgroup/user.slice/memory.max", "314572800\n");
  EXPECT_EQ(machine.limit_mib(), 300u);
  machine.put("/sys/fs/cgroup/user.slice/a/memory.max", "419430400\n");
  EXPECT_EQ(machine.limit_mib(), 300u);
  machine.put("/sys/fs/cgroup/user.slice/a/memory.high", "209715200\n");
  EXPECT_EQ(machine.limit_mib(), 200u);
  machine.put("/sys/fs/cgroup/user.slice/a/b/memory.max", "104857600\n");
  EXPECT_EQ(machine.limit_mib(), 100u);
  machine.put("/sys/fs/cgroup/user.slice/z/memory.max", "1048576\n");
  EXPECT_EQ(machine.limit_mib(), 100u) << "another group's limit";
}

TEST(MemoryLimit, KnowsVersion1) {
  Machine machine;
  machine.mount(kVersion1, "4:cpu:/batch\n3:memory:/batch/job\n0::/\n");
  machine.put("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(machine.limit_mib(), 1000u);
  machine.put("/sys/fs/cgroup/cpu/batch/memory.limit_in_bytes", "1048576\n");
  EXPECT_EQ(machine.limit_mib(), 1000u) << "not a controller of memory";
  machine.put("/sys/fs/cgroup/memory/batch/memory.limit_in_bytes", "524288000\n");
  EXPECT_EQ(machine.limit_mib(), 500u);
}

// The mount shows the container's group as its root, /proc/self/cgroup the path from the host's.
TEST(MemoryLimit, KnowsContainers) {
  Machine machine;
  machine.mount("35 31 0:32 /docker/0af /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n",
                "3:memory:/docker/0af/inner\n");
  machine.put("/sys/fs/cgroup/memory/memory.limit_in_bytes", "524288000\n");
  EXPECT_EQ(machine.limit_mib(), 500u);
  machine.put("/sys/fs/cgroup/memory/inner/memory.limit_in_bytes", "104857600\n");
  EXPECT_EQ(machine.limit_mib(), 100u);
}

TEST(MemoryLimit, SurvivesNonsense) {
  Machine machine;
  machine.mount("x\n - \n31 22 0:28 / - cgroup2\n", ":::\n0\n\n0::\n");
  EXPECT_EQ(machine.limit_mib(), 1000u);
  machine.put("/proc/meminfo", "MemTotal: much\n");
  EXPECT_GT(machine.limit_mib(), 0u);
  EXPECT_GT(memory_limit(machine.root() + "/missing"), 0u);
}

TEST(MemoryLimit, HeedsTheProcesssOwnLimit) {
  Machine machine;
  machine.put("/proc/meminfo", "MemTotal: 1000000000000 kB\n");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_DATA, &before), 0);
  rlimit lower = before;
  lower.rlim_cur = std::uint64_t{1} << 40;
  ASSERT_EQ(::setrlimit(RLIMIT_DATA, &lower), 0);
  const std::uint64_t limit = memory_limit(machine.root());
  ASSERT_EQ(::setrlimit(RLIMIT_DATA, &before), 0);
  EXPECT_LE(limit, std::uint64_t{1} << 40);
}

TEST(Processors, AreThoseTheProcessIsBoundTo) {
  cpu_set_t before;
  ASSERT_EQ(::sched_getaffinity(0, sizeof before, &before), 0);
  const Machine machine;
  EXPECT_EQ(machine.processors(), CPU_COUNT(&before));
  cpu_set_t one;
  CPU_ZERO(&one);
  for (int i = 0; CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &before)) CPU_SET(i, &one);
  }
  // In a thread of its own, which takes the bond with it.
  std::thread([&] {
    ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
#ifdef _OPENMP
    EXPECT_EQ(machine.processors(), 1);
#endif
  }).join();
}

TEST(Processors, AreNoMoreThanTheQuota) {
  Machine machine;
  const int all = machine.processors();
  machine.mount(kVersion2, "0::/pod/a\n");
  machine.put("/sys/fs/cgroup/pod/a/cpu.max", "max 100000\n");
  EXPECT_EQ(machine.processors(), all);
  machine.put("/sys/fs/cgroup/pod/cpu.max", "50000 100000\n");
  EXPECT_EQ(machine.processors(), 1) << "half a processor";
  machine.put("/sys/fs/cgroup/pod/cpu.max", "100000000 100000\n");
  EXPECT_EQ(machine.processors(), all) << "more than there are";
  machine.put("/sys/fs/cgroup/pod/a/cpu.max", "110000 100000\n");
  EXPECT_EQ(machine.processors(), std::min(all, 2)) << "rounded up";
  machine.put("/sys/fs/cgroup/pod/a/cpu.max", "much\n");
  EXPECT_EQ(machine.processors(), all);
}

TEST(Processors, AreNoMoreThanTheQuotaOfVersion1) {
  Machine machine;
  const int all = machine.processors();
  machine.mount(kVersion1, "4:cpu:/batch\n3:memory:/batch/job\n");
  machine.put("/sys/fs/cgroup/cpu/batch/cpu.cfs_quota_us", "-1\n");
  machine.put("/sys/fs/cgroup/cpu/batch/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(machine.processors(), all);
  machine.put("/sys/fs/cgroup/cpu/batch/cpu.cfs_quota_us", "100000\n");
  EXPECT_EQ(machine.processors(), 1);
}

TEST(Threads, AreThoseOfTheEnvironmentUnlessTheyAreChosen) {
  const char* before = std::getenv("OMP_NUM_THREADS");
  const std::string kept = before != nullptr ? before : "";
  const auto threads_with = [](const char* text) {
    ::setenv("OMP_NUM_THREADS", text, 1);
    set_thread_count(0);
    return thread_count();
  };
  EXPECT_EQ(threads_with("3"), 3);
  EXPECT_EQ(threads_with("5,2"), 5);
  for (const char* nonsense : {"", "0", "-4", "many"}) {
    EXPECT_EQ(threads_with(nonsense), available_processors()) << nonsense;
  }
  ::setenv("OMP_NUM_THREADS", "3", 1);
  set_thread_count(2);
  EXPECT_EQ(thread_count(), 2);
  ::unsetenv("OMP_NUM_THREADS");
  if (before != nullptr) ::setenv("OMP_NUM_THREADS", kept.c_str(), 1);
  set_thread_count(0);
}

TEST(AvailableMemory, IsWhatIsFreeOrSoonWouldBe) {
  Machine machine;
  machine.put("/proc/meminfo", "MemFree: 1 kB\nMemAvailable:  3072 kB\nSwapFree: 2048 kB\n");
  EXPECT_EQ(available_memory(machine.root()), 5 * kMiB);
  machine.put("/proc/meminfo", "MemAvailable:  3072 kB\n");
  EXPECT_EQ(available_memory(machine.root()), 3 * kMiB);
  EXPECT_GT(available_memory(machine.root() + "/missing"), std::uint64_t{1} << 60);
}

TEST(WrittenMemory, IsNotWhatIsOnlyAskedFor) {
  constexpr std::size_t kBytes = 64 * kMiB;
  const std::uint64_t before = written_memory(::getpid());
  void* block = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(block, MAP_FAILED);
  EXPECT_LT(written_memory(::getpid()), before + kBytes / 2);
  std::memset(block, 1, kBytes);
  EXPECT_GE(written_memory(::getpid()), before + kBytes - 8 * kMiB);
  ::munmap(block, kBytes);
}

TEST(ResidentMemory, CountsWhatIsTouched) {
  constexpr std::size_t kBytes = 64 * kMiB;
  const std::uint64_t before = current_rss_bytes();
  void* block = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(block, MAP_FAILED);
  std::memset(block, 1, kBytes);
  EXPECT_GE(current_rss_bytes(), before + kBytes - 8 * kMiB);
  ::munmap(block, kBytes);
  EXPECT_LT(current_rss_bytes(), before + kBytes / 2);
  EXPECT_GE(peak_rss_bytes(), before + kBytes - 8 * kMiB);
}

// Under AddressSanitizer, where nobody has set up glibc's heap: in one of ten such processes two
// first calls met in the middle of that.
TEST(ResidentMemory, IsTrimmedFromSeveralThreads) {
  std::atomic<int> ready{0};
  const auto trim = [&] {
    ++ready;
    while (ready < 2) {
    }
    trim_memory();
  };
  std::thread other(trim);
  trim();
  other.join();
}

// What a large parent had resident is none of its child's. The child is this same test.
TEST(ResidentMemory, PeakIsNotInheritedThroughExec) {
  constexpr const char* kIsChild = "TETFUSION_TEST_PRINTS_PEAK";
  if (std::getenv(kIsChild) != nullptr) {
    std::cout << "peak=" << peak_rss_bytes() << std::endl;
    return;
  }
  const std::vector<char> block(256 * kMiB, 1);
  ASSERT_GT(peak_rss_bytes(), block.size());
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::setenv(kIsChild, "1", 1);
    ::dup2(ends[1], STDOUT_FILENO);
    ::execl("/proc/self/exe", "test", "--gtest_filter=ResidentMemory.PeakIsNotInheritedThroughExec",
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n; (n = ::read(ends[0], buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  ::close(ends[0]);
  ::waitpid(child, nullptr, 0);
  const std::size_t at = text.find("peak=");
  ASSERT_NE(at, std::string::npos) << text;
  EXPECT_LT(std::stoull(text.substr(at + std::strlen("peak="))), 128 * kMiB);
}

TEST(PhaseClock, WhatIsMovedIsStillThere) {
  PhaseClock clock;
  clock.begin("write");
  clock.move("write", "fit", 2);
  clock.end();
  EXPECT_EQ(clock.seconds().at("fit"), 2);
  EXPECT_GE(clock.seconds().at("write"), -2);
  EXPECT_LT(clock.seconds().at("write"), -1);
}

// Two runs of a process, and the tasks that they start.
TEST(OwnThreadCount, IsThatOfOneThreadAndItsTasks) {
  set_thread_count(2);
  const auto seen_by_tasks = [](int threads) {
    const OwnThreadCount own;
    set_thread_count(threads);
    std::array<int, 6> seen{};
    run_tasks(seen.size(), 3, [&](std::size_t task, std::size_t) { seen[task] = thread_count(); });
    return seen;
  };
  std::array<int, 6> of_other{};
  std::thread other([&] { of_other = seen_by_tasks(7); });
  EXPECT_THAT(seen_by_tasks(5), ::testing::Each(5));
  other.join();
  EXPECT_THAT(of_other, ::testing::Each(7));
  EXPECT_EQ(thread_count(), 2);
  set_thread_count(0);
}

#ifdef _OPENMP
TEST(LoopThreads, AreThoseOfTheLoopsAlone) {
  set_thread_count(4);
  EXPECT_EQ(loop_threads(), 4);
  {
    const LoopThreads one(1);
    EXPECT_EQ(loop_threads(), 1);
    EXPECT_EQ(thread_count(), 4);
  }
  EXPECT_EQ(loop_threads(), 4);
  set_thread_count(0);
}
#endif

}  // namespace
}  // namespace tetfusion
