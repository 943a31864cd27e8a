#include "io/files/paged_array.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/resources.h"
#include "support/faulty_file_system.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::FaultyFileSystem;
using ::testing::HasSubstr;
using testing::TempDir;

TEST(PagedArray, IsZerosAndKeepsWhatIsPutIn) {
  const TempDir folder;
  for (const std::string& where : {std::string(), folder.path().string()}) {
    PagedArray<std::uint32_t> array(where, 1000);
    for (std::uint32_t i = 0; i < 1000; ++i) {
      ASSERT_EQ(array[i], 0U);
      array[i] = i;
    }
    for (std::uint32_t i = 1000; i < 3'000'000; ++i) array.push_back(i);
    array.let_go();
    EXPECT_EQ(array.size(), 3'000'000U);
    PagedArray<std::uint32_t> other = std::move(array);
    for (std::uint32_t i = 0; i < 3'000'000; ++i) ASSERT_EQ(other[i], i);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PagedArray, PagesOfAFileAreLetGoOf) {
  const TempDir folder;
  constexpr std::uint64_t kBytes = std::uint64_t{64} << 20;
  PagedArray<std::uint8_t> array(folder.path().string(), kBytes);
  for (std::uint64_t i = 0; i < kBytes; i += 512) array[i] = 7;
  const std::uint64_t before = current_rss_bytes();
  array.let_go();
  EXPECT_LT(current_rss_bytes() + kBytes / 2, before);
  for (std::uint64_t i = 0; i < kBytes; i += 512) ASSERT_EQ(array[i], 7);
}

TEST(PagedArray, ADiskThatIsFullIsSaid) {
  const TempDir folder;
  const auto refuses = [&](int error) {
    FaultyFileSystem system;
    system.fail_all(FaultyFileSystem::Call::kAllocate, error);
    try {
      PagedArray<int>(folder.path().string(), 100'000);
      ADD_FAILURE() << "there is room";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
      EXPECT_THAT(e.what(), HasSubstr(folder.path().string()));
      EXPECT_THAT(e.what(), HasSubstr("--scratch"));
    }
  };
  refuses(ENOSPC);
  refuses(EIO);
}

// Written there, so that a disk that is full is not found out by a page that gets no room.
TEST(PagedArray, AFileSystemThatCannotSetRoomAside) {
  const TempDir folder;
  for (const int error : {EOPNOTSUPP, ENOSYS}) {
    FaultyFileSystem system;
    system.fail_all(FaultyFileSystem::Call::kAllocate, error);
    PagedArray<int> array(folder.path().string(), 100'000);
    EXPECT_EQ(array[99'999], 0);
    array[99'999] = 5;
    EXPECT_EQ(array[99'999], 5);
    system.fill_up_after(0);
    EXPECT_THROW(PagedArray<int>(folder.path().string(), 100'000), Error);
  }
}

TEST(PagedArray, AFolderThatIsNotThere) {
  EXPECT_THROW(PagedArray<int>("/nowhere/at/all", 10), Error);
}

}  // namespace
}  // namespace tetfusion
