#include "base/vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "base/resources.h"

namespace tetfusion {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

// Under sanitizers arrays are of the heap, or have memory beside them, and what is too much ends
// the program.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Vector, IsTheSystemsMemoryAgainWhenItIsFreed) {
  // Whatever a heap has learnt to keep: glibc's keeps as much as was freed before.
  std::free(std::malloc(24 * kMiB));
  for (const std::size_t bytes : {kMiB, 3 * kMiB, 4 * kMiB, 9 * kMiB + 1}) {
    auto vector = std::make_unique<Vector<std::uint8_t>>(bytes);
    const std::vector<std::uint8_t> behind(1000, 1);  // so that a heap could not shrink
    const std::uint64_t before = current_rss_bytes();
    std::memset(vector->data(), 1, bytes);
    EXPECT_GE(current_rss_bytes(), before + bytes - bytes / 8) << bytes;
    vector.reset();
    EXPECT_LE(current_rss_bytes(), before + bytes / 8) << bytes;
    EXPECT_EQ(behind.back(), 1);
  }
}

TEST(Vector, TakesNoMoreThanWasWritten) {
  // A last huge page would add up to 2 MiB.
  Vector<std::uint8_t> vector(4 * kMiB + 4096);
  const std::uint64_t before = current_rss_bytes();
  std::memset(vector.data(), 1, vector.size());
  EXPECT_LE(current_rss_bytes(), before + vector.size() + kMiB / 2);
}

TEST(Vector, RefusesWhatNoMemoryHolds) {
  Vector<std::uint64_t> vector;
  EXPECT_THROW(vector.reserve(std::size_t{1} << 58), std::bad_alloc);
  EXPECT_THROW(detail::allocate_bytes(static_cast<std::size_t>(-1)), std::bad_alloc);
}
#endif

TEST(Vector, HoldsWhatWasPutInWhateverItsSize) {
  Vector<std::uint64_t> vector;
  for (std::uint64_t i = 0; i < 3'000'000; ++i) vector.push_back(i * i);  // 24 MB, by doubling
  const Vector<std::uint64_t> copy = vector;
  vector.resize(10);
  vector.shrink_to_fit();
  for (std::uint64_t i = 0; i < copy.size(); ++i) ASSERT_EQ(copy[i], i * i);
  EXPECT_EQ(vector, Vector<std::uint64_t>(copy.begin(), copy.begin() + 10));
}

}  // namespace
}  // namespace tetfusion
