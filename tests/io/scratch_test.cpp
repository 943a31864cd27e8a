#include "io/store/scratch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <thread>

#include "base/error.h"
#include "support/disk_scratch.h"
#include "support/faulty_file_system.h"
#include "support/pieces.h"

namespace tetfusion {
namespace {

using testing::add_pieces;
using ::testing::AllOf;
using testing::DiskScratchTest;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::pieces_in;
namespace fs = std::filesystem;

TEST_F(DiskScratchTest, FilesArePrivate) {
  const auto scratch = open();
  const auto store = run(scratch.get(), "one");
  struct stat status {};
  ASSERT_EQ(::stat(folder_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    ASSERT_EQ(::stat(entry.path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u) << entry.path();
  }
}

TEST_F(DiskScratchTest, GoesOnWithTheLatestCommit) {
  {
    const auto scratch = open();
    const auto one = run(scratch.get(), "one");
    const auto two = run(scratch.get(), "two");
    const auto three = scratch->begin("three");
    add_pieces(three.get(), 0, {{0, "not committed"}});
  }
  EXPECT_EQ(count_files("three"), 0u);
  {
    const auto scratch = open(true);
    auto checkpoint = scratch->resume();
    expect_whole(checkpoint, "two");
    const auto three = run(scratch.get(), "three");
  }
  const auto scratch = open(true);
  expect_whole(scratch->resume(), "three");
}

TEST_F(DiskScratchTest, WhatIsKeptBelongsToAllThatIsCommittedLater) {
  {
    const auto scratch = open();
    keep(scratch.get(), "log-1");
    run(scratch.get(), "one");
    keep(scratch.get(), "log-2");
    run(scratch.get(), "two");
    EXPECT_THROW(scratch->begin("log-1"), std::logic_error);
    keep(scratch.get(), "log-3");  // nothing is committed after that
  }
  {
    const auto scratch = open(true);
    const auto checkpoint = scratch->resume();
    expect_whole(checkpoint, "two");
    expect_kept(*checkpoint, {"log-1", "log-2"});
    keep(scratch.get(), "log-3");
    run(scratch.get(), "three");
    ASSERT_TRUE(soon([&] { return is_durable("three"); }));
  }
  const auto scratch = open(true);
  const auto checkpoint = scratch->resume();
  expect_whole(checkpoint, "three");
  expect_kept(*checkpoint, {"log-1", "log-2", "log-3"});
  scratch->remove();
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(DiskScratchTest, KeepsWhatIsDurableUntilSomethingNewerIs) {
  const auto scratch = open();
  run(scratch.get(), "one").reset();
  ASSERT_TRUE(soon([&] { return is_durable("one"); }));
  EXPECT_EQ(count_files("one."), 3u);
  run(scratch.get(), "two").reset();
  ASSERT_TRUE(soon([&] { return is_durable("two"); }));
  run(scratch.get(), "three").reset();
  ASSERT_TRUE(soon([&] { return is_durable("three"); }));
  run(scratch.get(), "four").reset();
  // The files of the first are overwritten, or removed.
  EXPECT_TRUE(soon([&] { return count_files("one.") == 0; }));
}

// What is committed stays, and what comes later finds its way.
TEST_F(DiskScratchTest, DropsWhatIsKeptToBeOverwritten) {
  const auto scratch = open();
  for (const char* name : {"one", "two"}) {
    run(scratch.get(), name).reset();
    ASSERT_TRUE(soon([&] { return is_durable(name); }));
  }
  ASSERT_TRUE(soon([&] { return count_files(".part") > 0; }));
  scratch->drop_spares();
  EXPECT_TRUE(soon([&] { return count_files(".part") == 0; }));
  EXPECT_EQ(count_files("two."), 3u);
  run(scratch.get(), "three").reset();
  EXPECT_TRUE(soon([&] { return is_durable("three"); }));
}

TEST_F(DiskScratchTest, DropsSparesWithoutACommit) {
  const auto scratch = open();
  for (auto name : {"one", "two"}) add_pieces(scratch->begin(name).get(), 0, {{0, "a"}});
  const auto store = scratch->begin("three");
  ASSERT_GT(count_files(".part"), 0u);
  scratch->drop_spares();
  EXPECT_TRUE(soon([&] { return count_files(".part") == 0; }));
  add_pieces(store.get(), 0, {{0, "a"}});
  EXPECT_EQ(count_files("three."), 1u);
}

// What was committed while the sync before it had not ended takes its place.
TEST_F(DiskScratchTest, ANewerCommitOvertakesASync) {
  std::atomic<bool> slow = false;
  {
    testing::FaultyFileSystem system;
    system.before([&](auto call) {
      while (call == testing::FaultyFileSystem::Call::kSync && slow) std::this_thread::yield();
    });
    const auto scratch = open();
    run(scratch.get(), "one").reset();
    ASSERT_TRUE(soon([&] { return is_durable("one"); }));
    slow = true;
    run(scratch.get(), "two").reset();
    run(scratch.get(), "three").reset();
    EXPECT_EQ(count_files("one."), 3u);
    slow = false;
    ASSERT_TRUE(soon([&] { return is_durable("three"); }));
    EXPECT_FALSE(is_durable("two"));
  }
  EXPECT_EQ(count_files("three."), 3u);
  EXPECT_EQ(count_files(""), 4u);
  const auto scratch = open(true);
  expect_whole(scratch->resume(), "three");
}

TEST_F(DiskScratchTest, AStoreStaysReadableAfterNewerCommits) {
  const auto scratch = open();
  const auto one = run(scratch.get(), "one");
  for (const char* name : {"two", "three", "four"}) {
    run(scratch.get(), name).reset();
    ASSERT_TRUE(soon([&] { return is_durable(name); }));
  }
  EXPECT_THAT(pieces_in(*one, 0), ElementsAre("one 0 to 0"));
}

TEST_F(DiskScratchTest, NamesThatAreInUseAreRefused) {
  const auto scratch = open();
  const auto store = run(scratch.get(), "one");
  EXPECT_THROW(scratch->begin("one"), std::logic_error);
  EXPECT_THROW(scratch->begin("One"), std::logic_error);
  EXPECT_THROW(scratch->begin("../one"), std::logic_error);
  EXPECT_THROW(scratch->begin(""), std::logic_error);
  EXPECT_THROW(scratch->commit("two", {}), std::logic_error);
  scratch->begin("two").reset();
  EXPECT_NO_THROW(scratch->begin("two"));
}

TEST_F(DiskScratchTest, RemoveLeavesNothing) {
  const auto scratch = open();
  const auto one = run(scratch.get(), "one");
  const auto two = scratch->begin("two");
  add_pieces(two.get(), 0, {{0, "not committed"}});
  scratch->remove();
  EXPECT_FALSE(fs::exists(folder_));
}

// Killed while it was removed, it is no work that somebody else must go on with.
TEST_F(DiskScratchTest, WhatIsLeftOfARemovalIsNoWork) {
  {
    testing::FaultyFileSystem system;
    const auto scratch = open();
    const auto one = run(scratch.get(), "one");
    system.fail_all(testing::FaultyFileSystem::Call::kUnlink, EIO);
    EXPECT_THROW(scratch->remove(), Error);
  }
  EXPECT_TRUE(fs::exists(folder_));
  const auto scratch = open();
  run(scratch.get(), "two").reset();
  scratch->remove();
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(DiskScratchTest, ARunThatCannotBeResumedLeavesNothing) {
  {
    const auto scratch = open();
    const auto store = scratch->begin("one");
    add_pieces(store.get(), 0, {{0, "not committed"}});
  }
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(DiskScratchTest, StartsAnewWhereThereIsNothingToResume) {
  const auto scratch = open(true);
  EXPECT_FALSE(scratch->resume().has_value());
  EXPECT_NO_THROW(run(scratch.get(), "one"));
}

TEST_F(DiskScratchTest, WorkIsNotOverwrittenUnasked) {
  {
    const auto scratch = open();
    run(scratch.get(), "one");
  }
  EXPECT_THAT(usage_error([&] { open(); }), AllOf(HasSubstr("--resume"), HasSubstr(folder_)));
  const auto scratch = open(true);
  expect_whole(scratch->resume(), "one");
}

TEST_F(DiskScratchTest, AnotherFingerprintIsRefused) {
  {
    const auto scratch = open(false, "mesh: a\ngoal: 90%");
    run(scratch.get(), "one");
  }
  EXPECT_THAT(usage_error([&] { open(true, "mesh: a\ngoal: 80%"); }),
              HasSubstr("it has 'goal: 90%', this run has 'goal: 80%'"));
  EXPECT_THAT(usage_error([&] { open(true, "mesh: a"); }),
              HasSubstr("it has 'goal: 90%', this run has ''"));
  const auto scratch = open(true, "mesh: a\ngoal: 90%");
  expect_whole(scratch->resume(), "one");
}

TEST_F(DiskScratchTest, ASecondProcessIsRefused) {
  const auto scratch = open();
  const auto store = run(scratch.get(), "one");
  EXPECT_THAT(usage_error([&] { open(true); }), HasSubstr("another process"));
  EXPECT_THAT(pieces_in(*store, 0), ElementsAre("one 0 to 0"));
}

TEST_F(DiskScratchTest, WhatIsNotOursIsRefusedAndKept) {
  fs::create_directory(folder_);
  const std::string theirs = folder_ + "/thesis.txt";
  std::ofstream(theirs) << "years of work";
  EXPECT_THAT(usage_error([&] { open(); }), HasSubstr("thesis.txt"));
  EXPECT_THAT(usage_error([&] { open(true); }), HasSubstr("thesis.txt"));
  fs::remove(theirs);
  {
    const auto scratch = open();
    const auto store = run(scratch.get(), "one");
    std::ofstream(theirs) << "years of work";
    scratch->remove();
  }
  EXPECT_EQ(fs::file_size(theirs), 13u);
  EXPECT_EQ(count_files(""), 1u);
}

// Nobody can remove them as long as the process that was killed is known to the network.
TEST_F(DiskScratchTest, WhatANetworkFileSystemLeavesIsInNobodysWay) {
  fs::create_directory(folder_);
  const std::string left = folder_ + "/.nfs000000000001e24000000001";
  std::ofstream(left) << "a manifest that was removed";
  {
    const auto scratch = open();
    run(scratch.get(), "one");
  }
  {
    const auto scratch = open(true);
    expect_whole(scratch->resume(), "one");
    scratch->remove();
  }
  EXPECT_TRUE(fs::exists(left));
  EXPECT_EQ(count_files(""), 1u);
}

TEST_F(DiskScratchTest, PartFilesWithoutAManifestAreNotOurs) {
  fs::create_directory(folder_);
  std::ofstream(folder_ + "/0.part") << "?";
  EXPECT_THAT(usage_error([&] { open(); }), HasSubstr("0.part"));
  EXPECT_TRUE(fs::exists(folder_ + "/0.part"));
}

TEST_F(DiskScratchTest, LinksAreNotFollowed) {
  const std::string target = dir_.file("target");
  fs::create_directory(target);
  fs::create_symlink(target, folder_);
  EXPECT_THAT(usage_error([&] { open(); }), HasSubstr("link"));
  fs::remove(folder_);
  fs::create_directory(folder_);
  fs::create_symlink(dir_.file("victim"), folder_ + "/manifest");
  EXPECT_THROW(open(), Error);
  EXPECT_FALSE(fs::exists(dir_.file("victim")));
}

TEST_F(DiskScratchTest, AFileOrNoParentIsRefused) {
  std::ofstream(folder_) << "a file";
  EXPECT_THAT(usage_error([&] { open(); }), HasSubstr("a file or a link"));
  folder_ = dir_.file("no/such");
  EXPECT_THROW(open(), Error);
}

TEST_F(DiskScratchTest, TooLittleRoomIsSaidBeforeTheStart) {
  ScratchOptions options;
  options.folder = folder_;
  options.expected_bytes = std::uint64_t{1} << 60;
  try {
    disk_scratch(options);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kIo);
    EXPECT_THAT(e.what(), AllOf(HasSubstr("1152921504606846976 bytes"), HasSubstr("has room for")));
  }
  EXPECT_FALSE(fs::exists(folder_));
}

// What a folder is refused for, whoever asks.
class RefusedScratch : public DiskScratchTest {
 protected:
  // Of the error that f() throws, with its code.
  static std::string error_of(const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& e) {
      return std::to_string(e.exit_code()) + " " + e.what();
    }
    return {};
  }
  std::set<std::string> files() const {
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(dir_.path())) {
      found.insert(entry.path().string() + " " +
                   (entry.is_regular_file() ? std::to_string(entry.file_size()) : ""));
    }
    return found;
  }
  void expect_refused(const std::string& part) {
    const std::set<std::string> before = files();
    const std::string said = error_of([&] { check_disk_scratch(options); });
    EXPECT_EQ(files(), before);
    EXPECT_THAT(said, HasSubstr(part));
    // Others may take room on that disk, or leave it, at any moment.
    const auto but_for_room = [](const std::string& text) {
      return text.substr(0, text.find("has room for"));
    };
    EXPECT_EQ(but_for_room(said), but_for_room(error_of([&] { disk_scratch(options); })));
  }
  void expect_taken() {
    const std::set<std::string> before = files();
    check_disk_scratch(options);
    EXPECT_EQ(files(), before);
    disk_scratch(options);
  }

  ScratchOptions options{folder_, "mesh: a", false, 0};
};

TEST_F(RefusedScratch, IsSoForWhoeverOnlyAsks) {
  expect_taken();
  run(open().get(), "one");
  expect_refused("--resume");
  options.resume = true;
  expect_taken();
  {
    const auto scratch = open(true);
    expect_refused("another process");
  }
  options.expected_bytes = std::uint64_t{1} << 60;
  expect_refused("has room for");
  options.fingerprint = "mesh: b";
  expect_refused("it has 'mesh: a', this run has 'mesh: b'");
  std::ofstream(folder_ + "/thesis.txt") << "years of work";
  expect_refused("thesis.txt");
}

TEST_F(RefusedScratch, IsSoBeforeItIsThere) {
  for (const char* end : {"", "/"}) {
    options = {folder_ + end, "mesh: a", false, std::uint64_t{1} << 60};
    expect_refused("has room for");
    fs::create_directory(folder_);
    expect_refused("has room for");
    options.folder = dir_.file("no/such") + end;
    expect_refused("does not exist; create it first");
    std::ofstream(folder_) << "a file";
    options.folder = folder_ + end;
    expect_refused("a file or a link");
    options.folder = folder_ + "/below" + end;
    expect_refused("cannot make it: Not a directory");
    fs::remove(folder_);
    fs::create_symlink(dir_.file("nowhere"), folder_);
    options.folder = folder_;
    expect_refused("a file or a link");
    fs::remove(folder_);
  }
}

TEST_F(RefusedScratch, IsSoWhereNothingCanBeMade) {
  for (const bool is_there : {false, true}) {
    if (is_there) fs::create_directory(folder_);
    testing::FaultyFileSystem system;
    system.fail_all(testing::FaultyFileSystem::Call::kAccess, EACCES);
    EXPECT_THAT(error_of([&] { check_disk_scratch(options); }), HasSubstr("Permission denied"));
  }
}

// A run is killed while it writes and commits; whatever the moment, the latest commit is whole.
TEST_F(DiskScratchTest, SurvivesBeingKilled) {
  for (int attempt = 0; attempt < 25; ++attempt) {
    fs::remove_all(folder_);
    int pipe[2];
    ASSERT_EQ(::pipe(pipe), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      const auto scratch = open();
      std::unique_ptr<PieceStore> before;
      for (int i = 0;; ++i) {
        before = run(scratch.get(), "round-" + std::to_string(i));
        if (::write(pipe[1], &i, sizeof(i)) != sizeof(i)) ::_exit(1);
      }
    }
    ::close(pipe[1]);
    int last = -1;
    for (int read = 0; read <= attempt; ++read) {
      ASSERT_EQ(::read(pipe[0], &last, sizeof(last)), static_cast<ssize_t>(sizeof(last)));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(137 * attempt));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    for (int more = 0; ::read(pipe[0], &more, sizeof(more)) == sizeof(more);) last = more;
    ::close(pipe[0]);
    const auto scratch = open(true);
    auto checkpoint = scratch->resume();
    ASSERT_TRUE(checkpoint.has_value());
    // The next one may have been committed before the parent was told.
    const int resumed = std::stoi(checkpoint->generation.substr(6));
    EXPECT_GE(resumed, last);
    EXPECT_LE(resumed, last + 1);
    expect_whole(checkpoint, "round-" + std::to_string(resumed));
  }
}

}  // namespace
}  // namespace tetfusion
