#include "base/vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "base/page_pool.h"

namespace tetfusion {
namespace {

// Under sanitizers arrays are of the heap, or have memory beside them, and what is too much ends
// the program.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(Vector, LargeOnesLieInThePool) {
  constexpr std::size_t kBytes = std::size_t{1} << 20;
  free_spare_pages();
  auto vector = std::make_unique<Vector<std::uint8_t>>(kBytes);
  const void* const data = vector->data();
  vector.reset();
  std::byte* const block = allocate_pages(2 * kBytes);  // and what was left of its huge page
  EXPECT_EQ(block, data);
  free_pages(block, 2 * kBytes);
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
