#include "io/files/output_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/error.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::FaultyFileSystem;
using ::testing::HasSubstr;
using testing::TempDir;
namespace fs = std::filesystem;

void write_all(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

void append(OutputFile* file, const std::string& text) { file->append(text.data(), text.size()); }

std::size_t count_files(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// The message of the Error(kIo) that f throws.
std::string io_error(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kIo);
    return e.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

// More than the buffer holds, no two pages alike.
std::string long_text() {
  std::string text;
  for (int i = 0; text.size() < 3 * OutputFile::kBufferBytes; ++i) text += std::to_string(i) + ' ';
  return text;
}

TEST(OutputFile, AppearsAtCommit) {
  const TempDir dir;
  OutputFile file(dir.file("a"));
  append(&file, "hello ");
  append(&file, "world");
  EXPECT_FALSE(fs::exists(dir.file("a")));
  EXPECT_EQ(file.size(), 11u);
  file.commit();
  EXPECT_EQ(bytes_of(dir.file("a")), "hello world");
  EXPECT_EQ(count_files(dir.path()), 1u);
}

TEST(OutputFile, LeavesTheOldFileWithoutCommit) {
  const TempDir dir;
  write_all(dir.file("a"), "old");
  {
    OutputFile file(dir.file("a"));
    append(&file, long_text());
  }
  EXPECT_EQ(bytes_of(dir.file("a")), "old");
  EXPECT_EQ(count_files(dir.path()), 1u);
}

TEST(OutputFile, CanBeReadBeforeItHasItsName) {
  const TempDir dir;
  write_all(dir.file("out"), "old");
  OutputFile file(dir.file("out"));
  append(&file, "new");
  EXPECT_EQ(bytes_of(file.path_to_read()), "new");
  append(&file, "er");
  EXPECT_EQ(bytes_of(file.path_to_read()), "newer");
  EXPECT_EQ(bytes_of(dir.file("out")), "old");
  file.commit();
  EXPECT_EQ(bytes_of(dir.file("out")), "newer");
  EXPECT_EQ(count_files(dir.path()), 1u);
  OutputFile spooled("/dev/null", OutputFile::Access::kPatch);
  append(&spooled, "put aside");
  EXPECT_EQ(bytes_of(spooled.path_to_read()), "put aside");
  EXPECT_THROW(OutputFile("/dev/null").path_to_read(), std::logic_error);
}

TEST(OutputFile, HoldsWhatWasAppendedInPartsOfAnySize) {
  const TempDir dir;
  const std::string text = long_text();
  for (const std::size_t part :
       {std::size_t{1000}, OutputFile::kBufferBytes / 2 + 1, text.size()}) {
    OutputFile file(dir.file("a"));
    for (std::size_t i = 0; i < text.size(); i += part) append(&file, text.substr(i, part));
    file.commit();
    EXPECT_EQ(bytes_of(dir.file("a")), text) << part;
  }
}

TEST(OutputFile, PatchesWhatIsBufferedAndWhatIsWritten) {
  const TempDir dir;
  std::string text = long_text();
  OutputFile file(dir.file("a"), OutputFile::Access::kPatch);
  append(&file, text);
  append(&file, "tail");
  file.overwrite(5, "FRONT", 5);
  file.overwrite(text.size() - 2, "BORDER", 6);
  append(&file, "end");
  file.commit();
  text.replace(5, 5, "FRONT");
  text.replace(text.size() - 2, 2, "BORDERend");
  EXPECT_EQ(bytes_of(dir.file("a")), text);
}

TEST(OutputFile, CanBeReadBeforeItHasAName) {
  const TempDir dir;
  OutputFile file(dir.file("a"));
  append(&file, "one");
  const MappedFile back = file.read_back();
  EXPECT_EQ(back.size(), 3u);
  EXPECT_EQ(std::memcmp(back.bytes().data(), "one", 3), 0);
  EXPECT_EQ(back.path(), dir.file("a"));
  EXPECT_FALSE(fs::exists(dir.file("a")));
  EXPECT_THROW(OutputFile("/dev/null").read_back(), std::logic_error);
}

TEST(OutputFile, RefusesToPatchPastTheEnd) {
  const TempDir dir;
  OutputFile file(dir.file("a"), OutputFile::Access::kPatch);
  append(&file, "four");
  EXPECT_THROW(file.overwrite(2, "abc", 3), std::logic_error);
}

TEST(OutputFile, GivesBackSpaceThatWasSetAsideForNothing) {
  const TempDir dir;
  OutputFile file(dir.file("a"));
  file.expect(std::uint64_t{8} << 20);
  append(&file, "short");
  file.commit();
  struct stat status {};
  ASSERT_EQ(::stat(dir.file("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_size, 5);
  EXPECT_LT(status.st_blocks, 1000);  // of 512 bytes
}

TEST(OutputFile, HasTheModeOfANormalFile) {
  const TempDir dir;
  const mode_t old = ::umask(027);
  OutputFile file(dir.file("a"));
  file.commit();
  ::umask(old);
  struct stat status {};
  ASSERT_EQ(::stat(dir.file("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(OutputFile, KeepsTheModeOfTheFileItReplaces) {
  const TempDir dir;
  write_all(dir.file("a"), "old");
  ASSERT_EQ(::chmod(dir.file("a").c_str(), 0600), 0);
  OutputFile file(dir.file("a"));
  file.commit();
  struct stat status {};
  ASSERT_EQ(::stat(dir.file("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST(OutputFile, WritesThroughLinks) {
  const TempDir dir;
  fs::create_directory(dir.path() / "sub");
  fs::create_symlink("sub/b", dir.path() / "link");
  fs::create_symlink("link", dir.path() / "link2");
  for (const char* text : {"dangling at first", "there already"}) {
    OutputFile file(dir.file("link2"));
    append(&file, text);
    file.commit();
    EXPECT_TRUE(fs::is_symlink(dir.path() / "link2"));
    EXPECT_EQ(bytes_of(dir.file("sub/b")), text);
  }
}

TEST(OutputFile, RefusesTargetsThatCannotBeWritten) {
  const TempDir dir;
  fs::create_directory(dir.path() / "folder");
  write_all(dir.file("file"), "");
  fs::create_symlink("circle", dir.path() / "circle");
  const auto refusal = [&](const std::string& path) {
    const std::string message = io_error([&] { check_output_path(path); });
    EXPECT_EQ(io_error([&] { OutputFile file(path); }), message);
    return message;
  };
  EXPECT_THAT(refusal(dir.file("missing/a")), HasSubstr("missing does not exist; create it first"));
  EXPECT_THAT(refusal(dir.file("missing/")), HasSubstr("does not exist"));
  EXPECT_THAT(refusal(dir.file("folder")), HasSubstr("is a folder"));
  EXPECT_THAT(refusal(dir.file("folder/")), HasSubstr("is a folder"));
  EXPECT_THAT(refusal(dir.file("file/a")), HasSubstr("Not a directory"));
  EXPECT_THAT(refusal(dir.file("circle")), HasSubstr("circle"));
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
  EXPECT_THAT(refusal(dir.file(std::string(300, 'x'))), HasSubstr("too long"));
  EXPECT_EQ(count_files(dir.path()), 3u);
}

// Nothing is read-only for root, so the system is made to say so.
TEST(OutputFile, RefusesReadOnlyTargets) {
  const TempDir dir;
  write_all(dir.file("file"), "old");
  FaultyFileSystem system;
  system.fail_all(FaultyFileSystem::Call::kAccess, EACCES);
  for (const char* name : {"new", "file"}) {
    const std::string message = io_error([&] { check_output_path(dir.file(name)); });
    EXPECT_THAT(message, HasSubstr(dir.file(name)));
    EXPECT_THAT(message, HasSubstr("Permission denied"));
  }
  EXPECT_EQ(count_files(dir.path()), 1u);
}

TEST(OutputFile, AcceptsWhatCanBeWritten) {
  const TempDir dir;
  check_output_path(dir.file("new"));
  check_output_path("-");
  check_output_path("/dev/null");
  const fs::path before = fs::current_path();
  fs::current_path(dir.path());
  check_output_path("name-in-the-current-folder");
  fs::current_path(before);
  EXPECT_EQ(count_files(dir.path()), 0u);
}

TEST(OutputFile, WritesDevicesInPlace) {
  for (const auto access : {OutputFile::Access::kAppend, OutputFile::Access::kPatch}) {
    OutputFile file("/dev/null", access);
    append(&file, long_text());
    file.commit();
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

// A file that is finished has no name yet; a device has its bytes.
TEST(OutputFile, IsFinishedBeforeItGetsItsName) {
  const TempDir dir;
  OutputFile file(dir.file("a"));
  append(&file, "all of it");
  file.finish();
  EXPECT_FALSE(fs::exists(dir.file("a")));
  file.commit();
  EXPECT_EQ(fs::file_size(dir.file("a")), 9u);
  OutputFile full("/dev/full", OutputFile::Access::kPatch);
  append(&full, "all of it");
  EXPECT_THROW(full.finish(), Error);
}

TEST(OutputFile, SaysHowMuchSpaceIsMissing) {
  const std::string message = io_error([] {
    OutputFile file("/dev/full");
    file.expect(std::uint64_t{5} << 30);
    append(&file, long_text());
    file.commit();
  });
  EXPECT_THAT(message, HasSubstr("no space left"));
  EXPECT_THAT(message, HasSubstr("needed about 5.0 GiB"));
}

// That the disk cannot be told to begin early is no failure.
TEST(OutputFile, StartsWritingBeforeCommit) {
  using Call = FaultyFileSystem::Call;
  const TempDir dir;
  for (const bool can : {true, false}) {
    FaultyFileSystem system;
    if (!can) system.fail_all(Call::kAdvise, EINVAL);
    std::atomic<int> advised = 0;
    system.before([&](Call call) { advised += call == Call::kAdvise; });
    OutputFile file(dir.file("a"));
    const std::string block(std::size_t{4} << 20, 'a');
    for (int i = 0; i < 40; ++i) append(&file, block);
    EXPECT_EQ(advised, 2);
    file.commit();
    EXPECT_EQ(fs::file_size(dir.file("a")), 40 * block.size());
  }
}

TEST(OutputFile, SaysThatNotTheTemporaryCopyHasNoRoom) {
  const std::string message = io_error([] {
    OutputFile file("/dev/full", OutputFile::Access::kPatch);
    append(&file, long_text());
    file.commit();
  });
  EXPECT_THAT(message, HasSubstr("no space left on the device for /dev/full: needed"));
  EXPECT_THAT(message, HasSubstr("0 bytes were written"));
}

TEST(OutputFile, RemovesTheTemporaryWhenWritingFails) {
  const TempDir dir;
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = limit;
  small.rlim_cur = 1 << 20;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string appending = io_error([&] {
    OutputFile file(dir.file("a"));
    append(&file, long_text());
    file.commit();
  });
  ::setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(appending, HasSubstr("File too large"));
  EXPECT_EQ(count_files(dir.path()), 0u);
}

class Streams : public ::testing::TestWithParam<OutputFile::Access> {};

TEST_P(Streams, WritesIntoAPipe) {
  const TempDir dir;
  const std::string text = long_text();
  ASSERT_EQ(::mkfifo(dir.file("pipe").c_str(), 0600), 0);
  std::string seen;
  std::thread reader([&] { seen = bytes_of(dir.file("pipe")); });
  {
    OutputFile file(dir.file("pipe"), GetParam());
    append(&file, text);
    file.commit();
  }
  reader.join();
  EXPECT_EQ(seen, text);
}

TEST_P(Streams, WritesToStandardOutput) {
  const TempDir dir;
  const std::string text = long_text();
  std::fflush(stdout);
  const int saved = ::dup(STDOUT_FILENO);
  std::FILE* target = std::fopen(dir.file("out").c_str(), "wb");
  ASSERT_NE(target, nullptr);
  ::dup2(::fileno(target), STDOUT_FILENO);
  {
    OutputFile file("-", GetParam());
    append(&file, text);
    file.commit();
  }
  ::dup2(saved, STDOUT_FILENO);
  ::close(saved);
  std::fclose(target);
  EXPECT_EQ(bytes_of(dir.file("out")), text);
}

std::string access_name(const ::testing::TestParamInfo<OutputFile::Access>& test) {
  return test.param == OutputFile::Access::kAppend ? "Append" : "Patch";
}
INSTANTIATE_TEST_SUITE_P(All, Streams,
                         ::testing::Values(OutputFile::Access::kAppend, OutputFile::Access::kPatch),
                         access_name);

}  // namespace
}  // namespace tetfusion
