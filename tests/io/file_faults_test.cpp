// Input and output files, with each of their file calls going wrong in turn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "base/error.h"
#include "io/files/mapped_file.h"
#include "io/files/output_file.h"
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

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// More than the buffer of an OutputFile, in parts that are buffered and a part that is not.
std::string new_text() {
  std::string text;
  for (int i = 0; text.size() < OutputFile::kBufferBytes + 5000; ++i) {
    text += std::to_string(i) + ' ';
  }
  return text;
}

// All that an OutputFile can do.
void write_output(const std::string& link, const std::string& text, std::uint64_t expected) {
  OutputFile file(link, OutputFile::Access::kPatch);
  file.expect(expected);
  file.append("????", 4);
  file.append(text.data() + 4, 1000);
  file.append(text.data() + 1004, text.size() - 1004);
  file.overwrite(0, text.data(), 4);
  file.commit();
}

// The parameter: does the file system know files without names?
class OutputFaults : public ::testing::TestWithParam<bool> {
 protected:
  // Writes with something wrong. Then the file is the new one, or the old one and an error said
  // why.
  std::int64_t write_with(const std::function<void(FaultyFileSystem*)>& set_up) {
    std::ofstream(target_, std::ios::binary) << "old";
    std::int64_t calls = 0;
    std::string message;
    {
      FaultyFileSystem system;
      if (!GetParam()) system.forbid_nameless();
      set_up(&system);
      try {
        write_output(dir_.file("link"), text_, text_.size() + 9000);
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kIo);
        EXPECT_TRUE(system.struck());
        message = e.what();
        EXPECT_THAT(message, HasSubstr(dir_.file("link")));
      }
      calls = system.calls();
    }
    failed_ = !message.empty();
    const std::string found = bytes_of(target_);
    EXPECT_TRUE(found == (failed_ ? "old" : text_)) << message << ": " << found.size() << " bytes";
    return calls;
  }

  void SetUp() override { fs::create_symlink("target", dir_.file("link")); }

  TempDir dir_ = TempDir::in_memory();
  std::string target_ = dir_.file("target");
  std::string text_ = new_text();
  bool failed_ = false;
};

TEST_P(OutputFaults, EveryCallFailsInTurn) {
  const std::int64_t calls = write_with([](FaultyFileSystem*) {});
  EXPECT_FALSE(failed_);
  int failures = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    for (const int error : {EIO, ENOSPC, EINTR, EACCES}) {
      write_with([&](FaultyFileSystem* system) { system->fail(n, error); });
      failures += failed_ ? 1 : 0;
      EXPECT_EQ(files_in(dir_.path()), 2u) << "a temporary file was left";
      if (HasFailure()) FAIL() << "call " << n << ", error " << error;
    }
  }
  EXPECT_GT(failures, calls);
}

TEST_P(OutputFaults, EveryTransferIsCutShortInTurn) {
  const std::int64_t calls = write_with([](FaultyFileSystem*) {});
  for (std::int64_t n = 0; n < calls; ++n) {
    write_with([&](FaultyFileSystem* system) { system->cut_short(n); });
    EXPECT_FALSE(failed_) << "call " << n;
  }
}

// With names a file is left wherever the process is killed. Without, where it has tried whether
// names can be given, and where the file has its temporary name: before it is removed, closed and
// renamed.
TEST_P(OutputFaults, KilledBetweenAnyTwoCalls) {
  const std::int64_t calls = write_with([](FaultyFileSystem*) {});
  std::int64_t left = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    write_with([&](FaultyFileSystem* system) { system->die(n); });
    if (HasFailure()) FAIL() << "call " << n;
    for (const auto& file : fs::directory_iterator(dir_.path())) {
      if (file.path().extension() != ".part") continue;
      ++left;
      fs::remove(file.path());
    }
  }
  if (GetParam()) {
    EXPECT_EQ(left, 3);
  } else {
    EXPECT_GT(left, 5);
  }
}

TEST_P(OutputFaults, ADiskThatFillsUpLeavesTheOldFile) {
  for (const auto room :
       {std::size_t{0}, std::size_t{4}, std::size_t{100000}, OutputFile::kBufferBytes}) {
    write_with(
        [&](FaultyFileSystem* system) { system->fill_up_after(static_cast<std::int64_t>(room)); });
    EXPECT_TRUE(failed_) << room;
    EXPECT_EQ(files_in(dir_.path()), 2u);
  }
}

// A network file system may report a lost write when the file is closed, and only then.
TEST_P(OutputFaults, AFailedCloseLeavesTheOldFile) {
  using Call = FaultyFileSystem::Call;
  for (const Call call : {Call::kClose, Call::kSync, Call::kRename}) {
    write_with([&](FaultyFileSystem* system) { system->fail_all(call, EIO); });
    EXPECT_TRUE(failed_);
    EXPECT_EQ(files_in(dir_.path()), 2u);
  }
}

// By way of a nameless file into a device.
TEST_P(OutputFaults, AStreamIsWholeOrAnError) {
  const auto write_to_null = [&](const std::function<void(FaultyFileSystem*)>& set_up) {
    FaultyFileSystem system;
    set_up(&system);
    failed_ = false;
    try {
      write_output("/dev/null", text_, text_.size());
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
      EXPECT_TRUE(system.struck()) << e.what();
      failed_ = true;
    }
    return system.calls();
  };
  const std::int64_t calls = write_to_null([](FaultyFileSystem*) {});
  EXPECT_FALSE(failed_);
  int failures = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    write_to_null([&](FaultyFileSystem* system) { system->fail(n, EIO); });
    failures += failed_ ? 1 : 0;
    write_to_null([&](FaultyFileSystem* system) { system->cut_short(n); });
    EXPECT_FALSE(failed_) << n;
  }
  EXPECT_GT(failures, 5);
}

INSTANTIATE_TEST_SUITE_P(All, OutputFaults, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Nameless" : "Named"; });

std::string mapped_text(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

// What `open` maps is right, or there is an error that says why; no descriptor is lost.
void expect_right_or_error(const std::function<MappedFile()>& open, const std::string& text) {
  std::int64_t calls = 0;
  {
    FaultyFileSystem system;
    EXPECT_EQ(mapped_text(open()), text);
    calls = system.calls();
  }
  const std::size_t open_files = files_in("/proc/self/fd");
  int failures = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    for (const int error : {EIO, EMFILE, EINTR, 0}) {
      FaultyFileSystem system;
      if (error == 0) {
        system.cut_short(n);
      } else {
        system.fail(n, error);
      }
      try {
        const MappedFile file = open();
        file.will_need(0, 100);
        EXPECT_EQ(mapped_text(file), text) << "call " << n;
        file.check();
      } catch (const Error& e) {
        ++failures;
        EXPECT_NE(error, 0) << e.what();
        EXPECT_TRUE(e.code() == ErrorCode::kIo || e.code() == ErrorCode::kInterrupted) << e.what();
      }
    }
  }
  EXPECT_GT(failures, 3);
  EXPECT_EQ(files_in("/proc/self/fd"), open_files);
}

TEST(InputFaults, EveryCallOfAMappedFileFailsInTurn) {
  const TempDir dir = TempDir::in_memory();
  const std::string text = "some bytes";
  std::ofstream(dir.file("a")) << text;
  expect_right_or_error([&] { return MappedFile::open(dir.file("a")); }, text);
}

TEST(InputFaults, EveryCallOfASpooledPipeFailsInTurn) {
  const std::string text(30000, 'x');
  const auto spool = [&] {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const Descriptor in(ends[0]);
    EXPECT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    ::close(ends[1]);
    return MappedFile::spool(in.get(), "a pipe");
  };
  expect_right_or_error(spool, text);
}

}  // namespace
}  // namespace tetfusion
