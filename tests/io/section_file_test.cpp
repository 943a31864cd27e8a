#include "io/store/section_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/files/file_system.h"
#include "io/store/scratch.h"
#include "support/mesh_file.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using testing::TempDir;
namespace fs = std::filesystem;

std::vector<PieceRef> refs(const std::vector<testing::PieceText>& pieces) {
  std::vector<PieceRef> result;
  for (const auto& piece : pieces) {
    result.push_back({piece.bucket, std::as_bytes(std::span(piece.text))});
  }
  return result;
}

SectionTable write(const std::string& path, const std::vector<testing::PieceText>& pieces) {
  const auto sections = refs(pieces);
  const SectionTable table = plan_sections(generation_id("one"), 9, sections);
  const Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT, 0600));
  EXPECT_EQ(write_sections(file.get(), table, sections), 0);
  return table;
}

SectionTable read(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY));
  return read_sections(file.get(), path);
}

TEST(SectionFile, TableComesBack) {
  const TempDir dir;
  const std::string path = dir.file("a");
  const SectionTable written = write(path, {{3, "abc"}, {4, std::string(5000, 'x')}, {70000, "z"}});
  const SectionTable table = read(path);
  EXPECT_EQ(table.generation, generation_id("one"));
  EXPECT_EQ(table.source, 9u);
  EXPECT_EQ(table.checksum, written.checksum);
  EXPECT_EQ(table.file_bytes, fs::file_size(path));
  ASSERT_EQ(table.sections.size(), 3u);
  EXPECT_EQ(table.sections[0].offset, 4096u);
  EXPECT_EQ(table.sections[1].offset, 8192u);
  EXPECT_EQ(table.sections[2].offset, 16384u);
  EXPECT_EQ(table.file_bytes, 16385u);
  EXPECT_EQ(table.sections[2].bucket, 70000u);
}

// The format is a promise to files that are on disks already.
TEST(SectionFile, IsLaidOutAsDocumented) {
  const TempDir dir;
  write(dir.file("a"), {{3, "abc"}});
  const std::string bytes = testing::bytes_of(dir.file("a"));
  ASSERT_EQ(bytes.size(), 4099u);
  EXPECT_EQ(bytes.substr(0, 8), "TFPIECES");
  EXPECT_EQ(bytes.substr(8, 8), std::string("\x04\x03\x02\x01\x01\0\0\0", 8));
  EXPECT_EQ(bytes.substr(16, 8), std::string("\x03\x10\0\0\0\0\0\0", 8));
  EXPECT_EQ(bytes.substr(32, 8), std::string("\x09\0\0\0\x01\0\0\0", 8));
  EXPECT_EQ(bytes.substr(64, 16), std::string("\0\x10\0\0\0\0\0\0\x03\0\0\0\0\0\0\0", 16));
  EXPECT_EQ(bytes.substr(4096), "abc");
}

TEST(SectionFile, OverwritesALongerFile) {
  const TempDir dir;
  const std::string path = dir.file("a");
  write(path, {{0, std::string(100000, 'x')}, {1, std::string(9, 'y')}});
  write(path, {{5, "short"}});
  EXPECT_EQ(read(path).file_bytes, 4101u);
  EXPECT_EQ(fs::file_size(path), 4101u);
}

TEST(SectionFile, RefusesWhatBreaksItsRules) {
  EXPECT_THROW(plan_sections(1, 1, refs({{2, "a"}, {2, "b"}})), std::logic_error);
  EXPECT_THROW(plan_sections(1, 1, refs({{2, "a"}, {1, "b"}})), std::logic_error);
  EXPECT_THROW(plan_sections(1, 1, refs({{2, ""}})), std::logic_error);
}

TEST(SectionFile, EveryFlippedByteOfTheHeadIsFound) {
  const TempDir dir;
  const std::string path = dir.file("a");
  write(path, {{3, "abc"}, {4, "defg"}});
  constexpr std::uint64_t kHead = 64 + 2 * 32 + 8;
  for (std::uint64_t at = 0; at < kHead; ++at) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const auto flip = [&] {
      file.seekg(static_cast<std::streamoff>(at));
      const int byte = file.get();
      file.seekp(static_cast<std::streamoff>(at));
      file.put(static_cast<char>(byte ^ 0x10)).flush();
    };
    flip();
    EXPECT_THROW(read(path), DamagedFile) << at;
    flip();
  }
  EXPECT_NO_THROW(read(path));
}

TEST(SectionFile, EveryOtherLengthIsFound) {
  const TempDir dir;
  const std::string path = dir.file("a");
  write(path, {{3, "abc"}, {4, "defg"}});
  for (std::uint64_t size = fs::file_size(path); size-- > 0;) {
    fs::resize_file(path, size);
    EXPECT_THROW(read(path), DamagedFile) << size;
  }
}

TEST(SectionFile, MessagesSayWhatWhereAndWhatToDo) {
  const TempDir dir;
  const std::string path = dir.file("a");
  write(path, {{3, "abc"}});
  fs::resize_file(path, 4098);
  try {
    read(path);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kIo);
    EXPECT_THAT(e.what(), HasSubstr(path + ": has 4098 bytes, 4099 expected"));
    EXPECT_THAT(e.what(), HasSubstr("remove the scratch folder"));
  }
  const std::string text = "abd";
  try {
    check_section(path, {4096, 3, 17, 3}, std::as_bytes(std::span(text)));
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("the section of bucket 3, 3 bytes from byte 4096"));
    EXPECT_THAT(e.what(), HasSubstr("0000000000000011 expected"));
  }
}

}  // namespace
}  // namespace tetfusion
