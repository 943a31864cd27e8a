// Scratch folders whose files are damaged: a run goes on with what is whole, or says what is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "support/disk_scratch.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"

namespace tetfusion {
namespace {

using testing::add_pieces;
using ::testing::AllOf;
using testing::bytes_of;
using testing::DiskScratchTest;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::pieces_in;
namespace fs = std::filesystem;

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

// What was kept for those that are lost is not asked of those that come instead.
TEST_F(DamagedScratch, WhatWasKeptForWhatIsLostIsForgotten) {
  {
    const auto scratch = open();
    keep(scratch.get(), "log-1");
    const auto one = run(scratch.get(), "one");  // held, its files stay
    keep(scratch.get(), "log-2");
    const auto two = run(scratch.get(), "two");
    keep(scratch.get(), "log-3");
    const auto three = run(scratch.get(), "three");
    ASSERT_TRUE(soon([&] { return is_durable("three"); }));
    for (const char* name : {"two", "three"}) fs::remove(folder_ + "/" + name + ".3.pieces");
    fs::copy(folder_, dir_.file("kept"));
  }
  fs::remove_all(folder_);
  fs::rename(dir_.file("kept"), folder_);
  {
    const auto scratch = open(true);
    expect_whole(scratch->resume(), "one");
    keep(scratch.get(), "log-2");
    run(scratch.get(), "again").reset();
    ASSERT_TRUE(soon([&] { return is_durable("again"); }));
  }
  const auto scratch = open(true);
  const auto checkpoint = scratch->resume();
  expect_whole(checkpoint, "again");
  expect_kept(*checkpoint, {"log-1", "log-2"});
}

// Under a store that is being read.
TEST_F(DamagedScratch, WhatIsDamagedWhileInUseIsAnError) {
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
  EXPECT_THROW(store->for_each(0, [](auto) { ADD_FAILURE(); }), Error);
}

// They are read, not mapped, so that what was read stays.
TEST_F(DamagedScratch, WhatIsDamagedAmongManyFilesIsAnError) {
  const auto scratch = open();
  const auto store = scratch->begin("one");
  for (std::uint32_t source = 0; source < 300; ++source) {
    add_pieces(store.get(), source, {{0, "from " + std::to_string(source)}});
  }
  store->seal();
  const auto held = store->read(0);
  const auto expect_error = [&](const char* file) {
    try {
      store->read(0);
      ADD_FAILURE();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
      EXPECT_THAT(e.what(), HasSubstr(file));
    }
  };
  const auto mode = std::ios::binary | std::ios::in | std::ios::out;
  std::fstream(folder_ + "/one.200.pieces", mode).seekp(4096) << "damage";
  expect_error("one.200.pieces: the section of bucket 0, 8 bytes from byte 4096");
  fs::resize_file(folder_ + "/one.100.pieces", 4100);
  expect_error("one.100.pieces");
  fs::remove(folder_ + "/one.50.pieces");
  expect_error("one.50.pieces");
  EXPECT_EQ(testing::text(held->pieces()[200]), "from 200");
  held->check();
}

TEST_F(DamagedScratch, AFileShortenedWhileItIsHeldIsAnError) {
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
  EXPECT_NO_THROW(scratch->check());
  held.reset();
  // Nothing that was computed from zeros is ever committed, or gets its name.
  EXPECT_THROW(scratch->check(), Error);
  EXPECT_THROW(scratch->commit("one", {}), Error);
}

}  // namespace
}  // namespace tetfusion
