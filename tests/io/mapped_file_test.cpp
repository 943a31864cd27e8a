#include "io/mapped_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>

#include "base/error.h"
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
  write_file(dir.file("b"), "second");
  MappedFile a = MappedFile::open(dir.file("a"));
  MappedFile b = MappedFile::open(dir.file("b"));
  a = std::move(b);
  EXPECT_EQ(text_of(a), "second");
  const MappedFile c = std::move(a);
  EXPECT_EQ(text_of(c), "second");
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

TEST(MappedFile, SpoolsAPipe) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "through", 7), 7);
  ::close(ends[1]);
  const MappedFile file = MappedFile::spool(ends[0], "-");
  ::close(ends[0]);
  EXPECT_EQ(text_of(file), "through");
  EXPECT_EQ(file.path(), "-");
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
