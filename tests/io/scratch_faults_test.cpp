// A small run in a scratch folder, with each of its file calls going wrong in turn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/store/scratch.h"
#include "support/faulty_file_system.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::add_pieces;
using testing::FaultyFileSystem;
using ::testing::HasSubstr;
using testing::pieces_in;
using testing::TempDir;
namespace fs = std::filesystem;
using Call = FaultyFileSystem::Call;

constexpr int kRounds = 4;

std::string name_of(int round) { return "round-" + std::to_string(round); }
std::string piece_of(int round, int source) {
  return std::string(static_cast<std::size_t>(3000 + 100 * round), static_cast<char>('a' + round)) +
         std::to_string(source);
}

void expect_round(const PieceStore& store, int round) {
  const std::vector<std::string> expected = {piece_of(round, 0), piece_of(round, 1)};
  EXPECT_EQ(pieces_in(store, 0), expected) << round;
  EXPECT_EQ(pieces_in(store, 1), std::vector<std::string>{"1"}) << round;
}

std::string log_of(int round) { return "log-" + std::to_string(round); }

// What a job does, from where it stands to the end, checking all that it reads. `*committed` is the
// last round that commit() has returned for; -1 in the end.
void run_job(const std::string& folder, bool resume, std::atomic<int>* committed) {
  ScratchOptions options;
  options.folder = folder;
  options.fingerprint = "job";
  options.resume = resume;
  options.expected_bytes = 1;
  const auto scratch = disk_scratch(options);
  std::unique_ptr<PieceStore> before;
  int round = 0;
  if (const auto checkpoint = resume ? scratch->resume() : std::nullopt) {
    round = std::stoi(testing::text(checkpoint->state)) + 1;
    ASSERT_EQ(checkpoint->generation, name_of(round - 1));
    expect_round(*checkpoint->pieces, round - 1);
    for (int kept = 0; kept < round; ++kept) {
      ASSERT_TRUE(checkpoint->kept.contains(log_of(kept))) << kept;
      EXPECT_EQ(pieces_in(*checkpoint->kept.at(log_of(kept)), 0),
                std::vector<std::string>{piece_of(kept, 7)});
    }
  }
  ASSERT_GE(round, *committed + 1) << "a committed round was lost";
  for (; round < kRounds; ++round) {
    auto store = scratch->begin(name_of(round));
    add_pieces(store.get(), 0, {{0, piece_of(round, 0)}});
    add_pieces(store.get(), 1, {{0, piece_of(round, 1)}, {1, "1"}});
    store->seal();
    store->will_read(0);
    if (before) expect_round(*before, round - 1);
    auto log = scratch->begin(log_of(round));
    add_pieces(log.get(), 0, {{0, piece_of(round, 7)}});
    log->seal();
    scratch->keep(log_of(round));
    log.reset();
    const std::string state = std::to_string(round);
    scratch->commit(name_of(round), std::as_bytes(std::span(state)));
    *committed = round;
    before = std::move(store);
  }
  // The job is done: what was committed is not needed any more.
  *committed = -1;
  scratch->remove();
}

// One run with something wrong; then the job goes on as if nothing had been, and must end well.
// Returns whether anything did go wrong.
bool run_with(const std::function<void(FaultyFileSystem*)>& set_up) {
  const TempDir dir = TempDir::in_memory();
  const std::string folder = dir.file("scratch");
  std::atomic<int> committed = -1;
  bool struck = false;
  {
    FaultyFileSystem system;
    set_up(&system);
    try {
      run_job(folder, false, &committed);
    } catch (const Error& e) {
      EXPECT_TRUE(e.code() == ErrorCode::kIo || e.code() == ErrorCode::kUsage) << e.what();
      EXPECT_TRUE(system.struck()) << e.what();
      EXPECT_THAT(e.what(), HasSubstr(folder));
    }
    struck = system.struck();
  }
  if (fs::exists(folder)) {
    run_job(folder, true, &committed);
    EXPECT_FALSE(fs::exists(folder));
  }
  return struck;
}

// Some calls are made by the thread that syncs, so their number varies a little.
std::int64_t calls_of_a_run() {
  const TempDir dir = TempDir::in_memory();
  FaultyFileSystem system;
  std::atomic<int> committed = -1;
  run_job(dir.file("scratch"), false, &committed);
  return system.calls();
}

TEST(ScratchFaults, EveryCallFailsInTurn) {
  const std::int64_t calls = calls_of_a_run();
  for (const int error : {EIO, ENOSPC, EINTR, EMFILE}) {
    for (std::int64_t n = 0; n < calls; ++n) {
      run_with([&](FaultyFileSystem* system) { system->fail(n, error); });
      if (::testing::Test::HasFailure()) FAIL() << "call " << n << " with " << std::strerror(error);
    }
  }
}

TEST(ScratchFaults, EveryTransferIsCutShortInTurn) {
  const std::int64_t calls = calls_of_a_run();
  for (std::int64_t n = 0; n < calls; ++n) {
    const TempDir dir = TempDir::in_memory();
    FaultyFileSystem system;
    system.cut_short(n);
    std::atomic<int> committed = -1;
    EXPECT_NO_THROW(run_job(dir.file("scratch"), false, &committed)) << n;
    EXPECT_FALSE(fs::exists(dir.file("scratch")));
  }
}

TEST(ScratchFaults, KilledBetweenAnyTwoCalls) {
  const std::int64_t calls = calls_of_a_run();
  std::int64_t killed = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    killed += run_with([&](FaultyFileSystem* system) { system->die(n); }) ? 1 : 0;
    if (::testing::Test::HasFailure()) FAIL() << "call " << n;
  }
  EXPECT_GT(killed, calls / 2);
}

// The same for a run that was resumed: it reads the manifest and what is there.
TEST(ScratchFaults, EveryCallOfAResumedRunFailsInTurn) {
  const TempDir kept = TempDir::in_memory();
  {
    // Dies in its third round.
    FaultyFileSystem system;
    std::atomic<int> committed = -1;
    system.before([&](Call) {
      if (committed == 2) system.die(0);
    });
    EXPECT_THROW(run_job(kept.file("scratch"), false, &committed), Error);
  }
  const auto resumed = [&](const std::function<void(FaultyFileSystem*)>& set_up) {
    const TempDir dir = TempDir::in_memory();
    const std::string folder = dir.file("scratch");
    fs::copy(kept.file("scratch"), folder);
    std::atomic<int> committed = 2;
    std::int64_t calls = 0;
    {
      FaultyFileSystem system;
      set_up(&system);
      try {
        run_job(folder, true, &committed);
      } catch (const Error& e) {
        EXPECT_TRUE(system.struck()) << e.what();
      }
      calls = system.calls();
    }
    if (fs::exists(folder)) run_job(folder, true, &committed);
    return calls;
  };
  const std::int64_t calls = resumed([](FaultyFileSystem*) {});
  for (std::int64_t n = 0; n < calls; ++n) {
    for (const int error : {EIO, EINTR, ENOMEM}) {
      resumed([&](FaultyFileSystem* system) { system->fail(n, error); });
    }
    resumed([&](FaultyFileSystem* system) { system->cut_short(n); });
    resumed([&](FaultyFileSystem* system) { system->die(n); });
    if (::testing::Test::HasFailure()) FAIL() << "call " << n;
  }
}

TEST(ScratchFaults, ADiskThatFillsUpIsAnErrorThatSaysSo) {
  for (const std::int64_t room : {0, 100, 5000, 9000, 20000, 30000, 40000}) {
    const TempDir dir = TempDir::in_memory();
    std::atomic<int> committed = -1;
    {
      FaultyFileSystem system;
      system.fill_up_after(room);
      try {
        run_job(dir.file("scratch"), false, &committed);
        ADD_FAILURE() << room;
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kIo);
        EXPECT_TRUE(std::string(e.what()).find("No space left") != std::string::npos) << e.what();
      }
    }
    if (fs::exists(dir.file("scratch"))) run_job(dir.file("scratch"), true, &committed);
  }
}

TEST(ScratchFaults, ADiskThatCannotSetSpaceAsideWillDo) {
  const TempDir dir = TempDir::in_memory();
  FaultyFileSystem system;
  system.fail_all(Call::kAllocate, EOPNOTSUPP);
  std::atomic<int> committed = -1;
  EXPECT_NO_THROW(run_job(dir.file("scratch"), false, &committed));
}

TEST(ScratchFaults, AFailedSyncIsToldAtTheNextCommit) {
  const TempDir dir = TempDir::in_memory();
  FaultyFileSystem system;
  ScratchOptions options;
  options.folder = dir.file("scratch");
  const auto scratch = disk_scratch(options);
  system.fail_all(Call::kSync, EIO);
  const auto commit = [&](const std::string& name) {
    auto store = scratch->begin(name);
    add_pieces(store.get(), 0, {{0, "piece"}});
    store->seal();
    scratch->commit(name, {});
    return store;
  };
  std::string message;
  std::vector<std::unique_ptr<PieceStore>> stores;
  for (int i = 0; i < 100000 && message.empty(); ++i) {
    try {
      stores.push_back(commit(name_of(i)));
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
      message = e.what();
    }
  }
  EXPECT_THAT(message, HasSubstr("cannot sync it"));
  EXPECT_EQ(pieces_in(*stores.back(), 0), std::vector<std::string>{"piece"});
}

TEST(ScratchFaults, ALockThatIsNotSupportedIsAnError) {
  const TempDir dir = TempDir::in_memory();
  FaultyFileSystem system;
  system.fail_all(Call::kLock, ENOLCK);
  std::atomic<int> committed = -1;
  try {
    run_job(dir.file("scratch"), false, &committed);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kIo);
    EXPECT_THAT(e.what(), HasSubstr("cannot lock"));
  }
  EXPECT_FALSE(fs::exists(dir.file("scratch")));
}

}  // namespace
}  // namespace tetfusion
