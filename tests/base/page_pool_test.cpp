#include "base/page_pool.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "base/resources.h"
#include "support/units.h"

namespace tetfusion {
namespace {

using testing::kMiB;

// Under sanitizers blocks are of the heap, or have memory beside them, and what is too much ends
// the program.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(PagePool, KeepsNoMoreThanItSays) {
  free_spare_pages();
  const std::uint64_t before = current_rss_bytes();
  std::vector<std::pair<std::byte*, std::size_t>> blocks;
  for (const std::size_t bytes : {kMiB, 3 * kMiB, 40 * kMiB, 9 * kMiB + 1, 7 * kMiB}) {
    blocks.emplace_back(allocate_pages(bytes), bytes);
    std::memset(blocks.back().first, 1, bytes);
  }
  EXPECT_GE(current_rss_bytes(), before + 55 * kMiB);
  for (const auto& [block, bytes] : blocks) free_pages(block, bytes);
  EXPECT_LE(current_rss_bytes(), before + kMostSparePages + kMiB);
  free_spare_pages();
  EXPECT_LE(current_rss_bytes(), before + kMiB);
}

// Whatever a heap has learnt to keep: glibc's keeps as much as was freed before.
TEST(PagePool, IsNotTheHeap) {
  std::free(std::malloc(24 * kMiB));
  std::byte* const block = allocate_pages(9 * kMiB);
  std::memset(block, 1, 9 * kMiB);
  const std::vector<char> behind(1000, 1);  // so that a heap could not shrink
  const std::uint64_t before = current_rss_bytes();
  free_pages(block, 9 * kMiB);
  free_spare_pages();
  EXPECT_LE(current_rss_bytes(), before - 8 * kMiB);
  EXPECT_EQ(behind.back(), 1);
}

TEST(PagePool, TakesNoMoreThanWasWrittenButARestOfAHugePage) {
  free_spare_pages();
  const std::uint64_t before = current_rss_bytes();
  std::byte* const block = allocate_pages(40 * kMiB);
  std::memset(block, 1, 5 * kMiB);
  EXPECT_LE(current_rss_bytes(), before + 6 * kMiB + kMiB / 2);
  free_pages(block, 40 * kMiB);
}

TEST(PagePool, UsesWhatWasFreed) {
  free_spare_pages();
  std::byte* const first = allocate_pages(3 * kMiB);
  free_pages(first, 3 * kMiB);
  std::byte* const second = allocate_pages(2 * kMiB);
  std::byte* const third = allocate_pages(kMiB);
  EXPECT_EQ(second, first);
  EXPECT_EQ(third, first + 2 * kMiB);
  free_pages(third, kMiB);
  free_pages(second, 2 * kMiB);
}

TEST(PagePool, RefusesWhatNoMemoryHolds) {
  EXPECT_THROW(allocate_pages(std::numeric_limits<std::size_t>::max()), std::bad_alloc);
  EXPECT_THROW(allocate_pages(std::size_t{1} << 60), std::bad_alloc);
}
#endif

// Every block holds a pattern of its own from when it is taken to when it is freed.
TEST(PagePool, GivesEachByteToOneBlockOnSeveralThreads) {
  const auto work = [](unsigned seed) {
    std::mt19937 random(seed);
    struct Block {
      std::byte* data;
      std::size_t bytes;
      unsigned char pattern;
    };
    std::vector<Block> blocks;
    const auto release = [&](std::size_t i) {
      const Block block = blocks[i];
      blocks[i] = blocks.back();
      blocks.pop_back();
      std::size_t wrong = 0;
      for (std::size_t k = 0; k < block.bytes; ++k) {
        wrong += std::to_integer<unsigned char>(block.data[k]) == block.pattern ? 0 : 1;
      }
      EXPECT_EQ(wrong, 0u);
      free_pages(block.data, block.bytes);
    };
    for (int step = 0; step < 150; ++step) {
      if (blocks.size() > 8 || (!blocks.empty() && random() % 3 == 0)) {
        release(random() % blocks.size());
        continue;
      }
      const std::size_t bytes = 1 + random() % (random() % 4 == 0 ? 5 * kMiB : 300'000);
      std::byte* const data = allocate_pages(bytes);
      EXPECT_EQ(reinterpret_cast<std::size_t>(data) % 64, 0u);
      const auto pattern = static_cast<unsigned char>(random() % 256);
      std::memset(data, pattern, bytes);
      blocks.push_back({data, bytes, pattern});
      if (step % 50 == 49) free_spare_pages();
    }
    while (!blocks.empty()) release(0);
  };
  std::thread other(work, 7);
  work(3);
  other.join();
}

}  // namespace
}  // namespace tetfusion
