#include "io/files/mapped_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "base/error.h"
#include "io/files/checksum.h"
#include "support/faulty_file_system.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::FaultyFileSystem;
using testing::TempDir;
using testing::write_file;

std::string text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

// The code of the error that opening `path` throws; the message must name the path.
int code_of_opening(const std::string& path) {
  try {
    MappedFile::open(path);
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    return e.exit_code();
  }
  return 0;
}

TEST(MappedFile, HoldsTheBytesOfTheFile) {
  const TempDir dir;
  write_file(dir.file("a"), std::string("ab\0c", 4));
  const MappedFile file = MappedFile::open(dir.file("a"));
  EXPECT_EQ(file.size(), 4u);
  EXPECT_EQ(text_of(file), std::string("ab\0c", 4));
  EXPECT_EQ(file.path(), dir.file("a"));
}

TEST(MappedFile, MovesWithItsMapping) {
  const TempDir dir;
  write_file(dir.file("a"), "first");
  MappedFile a = MappedFile::open(dir.file("a"));
  const MappedFile b = std::move(a);
  EXPECT_EQ(text_of(b), "first");
}

TEST(MappedFile, HintsChangeNothing) {
  const TempDir dir;
  write_file(dir.file("a"), std::string(10000, 'x'));
  const MappedFile file = MappedFile::open(dir.file("a"));
  file.will_need(5000, 100);
  file.populate(4097, 20000);
  file.dont_need(0, 10000);
  file.dont_need_around(5000, 1);
  file.dont_need_around(9999, 10);
  file.dont_need_around(10000, 1);
  file.populate(10000, 1);
  file.populate(0, 0);
  EXPECT_EQ(text_of(file), std::string(10000, 'x'));
}

TEST(MappedFile, RefusesWhatIsNotThereOrNotAFile) {
  const TempDir dir;
  EXPECT_EQ(code_of_opening(dir.file("missing")), 4);
  EXPECT_EQ(code_of_opening(dir.path().string()), 4);
}

// Root may read everything, so the system is made to refuse.
TEST(MappedFile, RefusesWhatMayNotBeRead) {
  const TempDir dir;
  write_file(dir.file("a"), "x");
  FaultyFileSystem system;
  system.fail_all(FaultyFileSystem::Call::kOpen, EACCES);
  EXPECT_EQ(code_of_opening(dir.file("a")), 4);
}

TEST(MappedFile, RefusesAnEmptyFile) {
  const TempDir dir;
  write_file(dir.file("a"), "");
  EXPECT_EQ(code_of_opening(dir.file("a")), 3);
}

TEST(MappedFile, MissingPagesReadAsZerosAndAreReported) {
  const TempDir dir;
  const std::string content(300000, 'x');
  write_file(dir.file("a"), content);
  const MappedFile file = MappedFile::open(dir.file("a"));
  file.check();
  std::filesystem::resize_file(dir.file("a"), 100000);
  std::size_t zeros = 0;
  for (const std::byte b : file.bytes()) zeros += b == std::byte{0} ? 1 : 0;
  EXPECT_EQ(zeros, 200000u);
  EXPECT_THROW(file.check(), Error);
  // The file is whole again, but what was read is not.
  std::filesystem::resize_file(dir.file("a"), 300000);
  EXPECT_THROW(file.check(), Error);
}

// What a pipe holds, spooled.
MappedFile spool_text(const std::string& text, const std::string& folder = {}) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const Descriptor in(ends[0]);
  const std::jthread writer([&] {
    for (std::size_t i = 0; i < text.size(); i += 999) {
      const std::size_t n = std::min<std::size_t>(999, text.size() - i);
      EXPECT_EQ(::write(ends[1], text.data() + i, n), static_cast<ssize_t>(n));
    }
    ::close(ends[1]);
  });
  return MappedFile::spool(in.get(), "-", folder);
}

TEST(MappedFile, SpoolsAPipe) {
  const MappedFile file = spool_text("through");
  EXPECT_EQ(text_of(file), "through");
  EXPECT_EQ(file.path(), "-");
}

TEST(MappedFile, KnowsTheChecksumOfWhatWasSpooled) {
  std::string text;
  for (int i = 0; text.size() < 300'000; ++i) text += std::to_string(i);
  const MappedFile file = spool_text(text);
  EXPECT_EQ(text_of(file), text);
  EXPECT_EQ(file.spooled_checksum(), checksum(file.bytes()));
  const TempDir dir;
  write_file(dir.file("a"), text);
  EXPECT_FALSE(MappedFile::open(dir.file("a")).spooled_checksum());
}

// The copy has no name, but the system remembers in which folder it was made.
TEST(MappedFile, SpoolsToTheDiskOfTheFolder) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path() / "there");
  for (const char* name : {"there", "there/not-yet"}) {
    const MappedFile file = spool_text("through", dir.file(name));
    EXPECT_EQ(text_of(file), "through");
    const auto place =
        std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file.fd())).string();
    EXPECT_TRUE(place.starts_with(dir.file("there/"))) << place;
    EXPECT_TRUE(std::filesystem::is_empty(dir.path() / "there"));
  }
  EXPECT_THROW(spool_text("", dir.file("neither/nor")), Error);
}

// As long as bytes come it never waits.
TEST(MappedFile, StopsSpoolingWhenItIsCancelled) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::atomic<bool> cancelled = true;
  EXPECT_EQ(::write(ends[1], "some", 4), 4);
  EXPECT_THROW(MappedFile::spool(ends[0], "-", {}, &cancelled), Error);
  ::close(ends[0]);
  ::close(ends[1]);
}

// A full disk is named with the folder, and what to do.
TEST(MappedFile, SaysWhereACopyHasNoRoom) {
  const TempDir dir;
  for (const std::string& folder : {std::string(), dir.path().string()}) {
    FaultyFileSystem system;
    system.fill_up_after(3);
    try {
      spool_text("through", folder);
      ADD_FAILURE();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
      const std::string message = e.what();
      EXPECT_NE(message.find(folder.empty() ? "TMPDIR" : folder), std::string::npos) << message;
      EXPECT_EQ(message.find("--scratch") == std::string::npos, folder.empty()) << message;
    }
  }
}

TEST(MappedFile, RefusesAnEmptyPipe) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ::close(ends[1]);
  EXPECT_THROW(MappedFile::spool(ends[0], "-"), Error);
  ::close(ends[0]);
}

TEST(MappedFile, SaysWhenSpoolingFails) {
  // A descriptor that is not open cannot be read.
  EXPECT_THROW(MappedFile::spool(-1, "-"), Error);
}

}  // namespace
}  // namespace tetfusion
