#include "io/scratch.h"

#include <fcntl.h>
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
#include <stdexcept>
#include <string>
#include <thread>

#include "base/error.h"
#include "io/file_system.h"
#include "io/manifest.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::add_pieces;
using ::testing::AllOf;
using testing::bytes_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::pieces_in;
using testing::TempDir;
namespace fs = std::filesystem;

class DiskScratchTest : public ::testing::Test {
 protected:
  std::unique_ptr<Scratch> open(bool resume = false, const std::string& fingerprint = "mesh: a") {
    ScratchOptions options;
    options.folder = folder_;
    options.fingerprint = fingerprint;
    options.resume = resume;
    return disk_scratch(options);
  }

  // A generation whose pieces and state say its name.
  static std::unique_ptr<PieceStore> run(Scratch* scratch, const std::string& name) {
    auto store = scratch->begin(name);
    add_pieces(store.get(), 0, {{0, name + " 0 to 0"}, {1, std::string(5000, name.back())}});
    add_pieces(store.get(), 3, {{1, name + " 3 to 1"}});
    store->seal();
    const std::string state = "state of " + name;
    scratch->commit(name, std::as_bytes(std::span(state)));
    return store;
  }

  static void keep(Scratch* scratch, const std::string& name) {
    const auto store = scratch->begin(name);
    add_pieces(store.get(), 2, {{1, "of " + name}});
    store->seal();
    scratch->keep(name);
  }

  static void expect_kept(const Checkpoint& checkpoint, const std::vector<std::string>& names) {
    EXPECT_EQ(checkpoint.kept.size(), names.size());
    for (const std::string& name : names) {
      ASSERT_TRUE(checkpoint.kept.contains(name)) << name;
      EXPECT_THAT(pieces_in(*checkpoint.kept.at(name), 1), ElementsAre("of " + name));
    }
  }

  static void expect_whole(const std::optional<Checkpoint>& checkpoint, const std::string& name) {
    ASSERT_TRUE(checkpoint.has_value());
    EXPECT_EQ(checkpoint->generation, name);
    EXPECT_EQ(testing::text(checkpoint->state), "state of " + name);
    EXPECT_THAT(pieces_in(*checkpoint->pieces, 0), ElementsAre(name + " 0 to 0"));
    EXPECT_THAT(pieces_in(*checkpoint->pieces, 1),
                ElementsAre(std::string(5000, name.back()), name + " 3 to 1"));
  }

  std::size_t count_files(const std::string& part) const {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().filename().string().find(part) != std::string::npos) ++count;
    }
    return count;
  }

  bool is_durable(const std::string& name) const {
    const Manifest manifest(Descriptor(::open((folder_ + "/manifest").c_str(), O_RDWR)),
                            "manifest");
    for (const Commit& commit : manifest.commits()) {
      if (commit.name == name && commit.durable) return true;
    }
    return false;
  }

  static bool soon(const std::function<bool()>& condition) {
    for (int i = 0; i < 1000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  static std::string usage_error(const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      return e.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  TempDir dir_ = TempDir::in_memory();
  std::string folder_ = dir_.file("scratch");
};

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

class DamagedScratch : public DiskScratchTest {
 protected:
  // Two generations, not durable unless the disk is quick.
  void prepare() {
    const auto scratch = open();
    keep(scratch.get(), "log-1");
    run(scratch.get(), "one");
    keep(scratch.get(), "log-2");
    run(scratch.get(), "two");
  }

  // Resumes and reads all; what comes back must be right. Tells what happened.
  std::string outcome() {
    try {
      const auto scratch = open(true);
      const auto checkpoint = scratch->resume();
      if (!checkpoint) return "nothing";
      expect_whole(checkpoint, checkpoint->generation);
      if (checkpoint->generation == "two") {
        expect_kept(*checkpoint, {"log-1", "log-2"});
      } else if (!checkpoint->kept.empty()) {
        expect_kept(*checkpoint, {"log-1"});
      }
      return checkpoint->generation;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo) << e.what();
      return "error";
    }
  }
};

// Runs `damage` over every file, and every length or byte of it.
void for_each_damage(const std::string& folder, const std::string& kept,
                     const std::function<void(const fs::path&, const std::string&)>& damage) {
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(kept)) names.push_back(entry.path().filename());
  for (const fs::path& name : names) {
    const std::string whole = bytes_of(fs::path(kept) / name);
    fs::remove_all(folder);
    fs::copy(kept, folder);
    damage(fs::path(folder) / name, whole);
  }
}

TEST_F(DamagedScratch, EveryFlippedByteIsFoundOrDoesNoHarm) {
  prepare();
  const std::string kept = dir_.file("kept");
  fs::rename(folder_, kept);
  for_each_damage(folder_, kept, [&](const fs::path& file, const std::string& whole) {
    // Of the sections' pages one byte in 13 will do.
    for (std::size_t at = 0; at < whole.size(); at += at < 256 || at % 4096 < 24 ? 1 : 13) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ 0x21);
      fs::remove_all(folder_);
      fs::copy(kept, folder_);
      std::ofstream(file, std::ios::binary) << flipped;
      outcome();
      if (HasFailure()) FAIL() << file << " byte " << at;
    }
  });
}

TEST_F(DamagedScratch, EveryLengthIsFoundOrDoesNoHarm) {
  prepare();
  const std::string kept = dir_.file("kept");
  fs::rename(folder_, kept);
  for_each_damage(folder_, kept, [&](const fs::path& file, const std::string& whole) {
    for (std::size_t size = 0; size < whole.size(); size += size < 256 ? 1 : 97) {
      fs::remove_all(folder_);
      fs::copy(kept, folder_);
      fs::resize_file(file, size);
      outcome();
      if (HasFailure()) FAIL() << file << " length " << size;
    }
  });
}

// A torn record is one that was being written: the commits before it stand.
TEST_F(DamagedScratch, ATornRecordIsIgnored) {
  {
    const auto scratch = open();
    const auto one = run(scratch.get(), "one");
    ASSERT_TRUE(soon([&] { return is_durable("one"); }));
  }
  {
    std::ofstream manifest(folder_ + "/manifest", std::ios::binary | std::ios::app);
    manifest << std::string("\x18\0\0\0\x02\0\0\0half", 12);
  }
  EXPECT_EQ(outcome(), "one");
}

TEST_F(DamagedScratch, AMissingFileLeavesTheGenerationBefore) {
  {
    const auto scratch = open();
    const auto one = run(scratch.get(), "one");
    ASSERT_TRUE(soon([&] { return is_durable("one"); }));
    const auto two = run(scratch.get(), "two");
    ASSERT_TRUE(soon([&] { return is_durable("two"); }));
    // "one" is held by its store, so its files are still there.
    fs::remove(folder_ + "/two.3.pieces");
    fs::copy(folder_, dir_.file("kept"));
  }
  fs::remove_all(folder_);
  fs::rename(dir_.file("kept"), folder_);
  EXPECT_EQ(outcome(), "one");
}

TEST_F(DamagedScratch, AMissingFileOfWhatIsKeptLeavesTheGenerationBefore) {
  {
    const auto scratch = open();
    const auto one = run(scratch.get(), "one");
    ASSERT_TRUE(soon([&] { return is_durable("one"); }));
    keep(scratch.get(), "log-1");
    const auto two = run(scratch.get(), "two");
    ASSERT_TRUE(soon([&] { return is_durable("two"); }));
    fs::remove(folder_ + "/log-1.2.pieces");
    fs::copy(folder_, dir_.file("kept"));
  }
  fs::remove_all(folder_);
  fs::rename(dir_.file("kept"), folder_);
  EXPECT_EQ(outcome(), "one");
}

// A newer one that is whole as far as its tables go, but not durable: its bytes are compared, and
// what is durable has been kept for it.
TEST_F(DamagedScratch, WhatIsNotDurableIsReadBeforeItIsBelieved) {
  {
    testing::FaultyFileSystem system;
    const auto scratch = open();
    run(scratch.get(), "one").reset();
    ASSERT_TRUE(soon([&] { return is_durable("one"); }));
    system.fail_all(testing::FaultyFileSystem::Call::kSync, EIO);
    run(scratch.get(), "two").reset();
    EXPECT_EQ(count_files("one."), 3u);
  }
  EXPECT_EQ(count_files("two."), 3u);
  const auto mode = std::ios::binary | std::ios::in | std::ios::out;
  std::fstream(folder_ + "/two.0.pieces", mode).seekp(9000) << "damage";
  EXPECT_EQ(outcome(), "one");
}

// Under a store that is being read.
TEST_F(DiskScratchTest, DamageWhileInUseIsAnError) {
  const auto scratch = open();
  const auto store = run(scratch.get(), "one");
  const std::string file = folder_ + "/one.0.pieces";
  std::fstream(file, std::ios::binary | std::ios::in | std::ios::out).seekp(8192 + 100) << "damage";
  EXPECT_THAT(pieces_in(*store, 0), ElementsAre("one 0 to 0"));
  try {
    store->read(1);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kIo);
    EXPECT_THAT(e.what(), AllOf(HasSubstr("one.0.pieces: the section of bucket 1, 5000 bytes from "
                                          "byte 8192"),
                                HasSubstr("expected")));
  }
  fs::remove(file);
  EXPECT_THROW(store->read(0), Error);
}

TEST_F(DiskScratchTest, AFileShortenedWhileItIsHeldIsAnError) {
  const auto scratch = open();
  const auto store = scratch->begin("one");
  add_pieces(store.get(), 0, {{0, std::string(100000, 'x')}});
  store->seal();
  auto held = store->read(0);
  EXPECT_NO_THROW(held->check());
  fs::resize_file(folder_ + "/one.0.pieces", 8192);
  EXPECT_THROW(held->check(), Error);
  EXPECT_EQ(testing::text(held->pieces().front()).size(), 100000u);  // no SIGBUS
  EXPECT_THROW(held->check(), Error);
  held.reset();
  // Nothing that was computed from zeros is ever committed.
  EXPECT_THROW(scratch->commit("one", {}), Error);
}

}  // namespace
}  // namespace tetfusion
