#include "vtk/vtk_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/units.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::kMiB;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kPath[] = "mesh.case";
constexpr char kNoError[] = "no error";

// The message of what the trial throws; no child is left behind.
std::string told_of(const std::function<void()>& work, const OpenOptions& options = {},
                    ErrorCode expected = ErrorCode::kBadInput) {
  std::string message = kNoError;
  try {
    try_in_child(kPath, options, work);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), expected) << error.what();
    message = error.what();
  }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
  return message;
}

[[maybe_unused]] char* ask_for(std::uint64_t bytes) {
  void* const block =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return block != MAP_FAILED ? static_cast<char*>(block) : throw std::bad_alloc();
}

[[maybe_unused]] void write_to(std::uint64_t bytes) { std::memset(ask_for(bytes), 1, bytes); }

// Not for ever, so that no test is.
void go_on() { std::this_thread::sleep_for(std::chrono::seconds(30)); }

TEST(VtkTrial, WorkThatIsDoneIsForgotten) {
  int done = 0;
  EXPECT_EQ(told_of([&] { done = 1; }), kNoError);
  EXPECT_EQ(done, 0);
}

// Sanitizers write to memory of their own for each byte that is written to.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(VtkTrial, MemoryIsBoundedByTwiceWhatTheRunHas) {
  OpenOptions options;
  options.memory = 200 * kMiB;
  const auto take = [](std::uint64_t bytes) {
    write_to(bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  };
  EXPECT_EQ(told_of([&] { take(350 * kMiB); }, options), kNoError);
  const auto take_more = [&] {
    write_to(450 * kMiB);
    go_on();
  };
  EXPECT_THAT(told_of(take_more, options, ErrorCode::kMemory),
              AllOf(StartsWith("mesh.case: VTK takes more than 400.0 MiB"),
                    HasSubstr("give --memory 400M or more"), HasSubstr("the file is damaged")));
  options.memory = 1;  // and small files are always read
  EXPECT_EQ(told_of([&] { take(200 * kMiB); }, options), kNoError);
}

TEST(VtkTrial, MemoryThatIsOnlyAskedForOrTheParentsDoesNotCount) {
  constexpr std::uint64_t kBytes = 400 * kMiB;
  char* const own = ask_for(kBytes);
  std::memset(own, 1, kBytes);
  OpenOptions options;
  options.memory = 1;
  const auto ask = [&] {
    ask_for(2048 * kMiB);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  };
  EXPECT_EQ(told_of(ask, options), kNoError);
  ::munmap(own, kBytes);
}
#endif

TEST(VtkTrial, ACallerThatGivesUpNeedNotWait) {
  std::atomic<bool> cancelled{false};
  OpenOptions options;
  options.cancelled = &cancelled;
  std::thread user([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    cancelled = true;
  });
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(told_of(go_on, options, ErrorCode::kInterrupted), HasSubstr("interrupted"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  user.join();
}

TEST(VtkTrial, SignalsEndTheChild) {
  for (const int number : {SIGHUP, SIGINT, SIGTERM}) {
    const auto raise = [&] { ::raise(number); };
    EXPECT_THAT(told_of(raise, {}, ErrorCode::kInterrupted), HasSubstr("interrupted"));
    const auto before = ::signal(number, SIG_IGN);  // as under nohup
    EXPECT_EQ(told_of(raise), kNoError) << number;
    ::signal(number, before);
  }
  EXPECT_THAT(told_of([] { ::raise(SIGKILL); }, {}, ErrorCode::kMemory),
              HasSubstr("not enough memory"));
  EXPECT_THAT(told_of([] { ::raise(SIGFPE); }), HasSubstr("the file is damaged"));
  EXPECT_THAT(told_of([] { std::exit(0); }), HasSubstr("VTK cannot go on"));
}

TEST(VtkTrial, ErrorsComeThroughAndWordsOfLibrariesDoNot) {
  EXPECT_EQ(told_of([] { throw Error(ErrorCode::kIo, "our words"); }, {}, ErrorCode::kIo),
            "our words");
  EXPECT_EQ(told_of([] { throw InvalidMesh("is met again"); }), kNoError);
  const auto count_is_wrong =
      AllOf(StartsWith("mesh.case: a count in it"), HasSubstr("the file is damaged"),
            Not(HasSubstr("vector")), Not(HasSubstr("bad_")));
  std::vector<int> list;
  EXPECT_THAT(told_of([&] { list.resize(list.max_size() + 1); }), count_is_wrong);
  EXPECT_THAT(told_of([] { throw std::bad_array_new_length(); }), count_is_wrong);
  EXPECT_THAT(told_of([] { throw std::bad_alloc(); }, {}, ErrorCode::kMemory),
              AllOf(StartsWith("mesh.case: there is not enough memory"), HasSubstr("damaged"),
                    Not(HasSubstr("bad_"))));
  EXPECT_THAT(told_of([] { throw std::runtime_error("no such thing"); }),
              AllOf(HasSubstr("VTK gives up"), HasSubstr("(no such thing)"), HasSubstr("damaged")));
  EXPECT_THAT(told_of([] { throw 1; }), HasSubstr("VTK gives up"));
}

}  // namespace
}  // namespace tetfusion
