#include "generate/permutation.h"

#include <gtest/gtest.h>

#include <vector>

namespace tetfusion {
namespace {

TEST(Permutation, HitsEveryNumberOnceAndInverts) {
  for (const std::uint64_t size :
       {1u, 2u, 3u, 5u, 8u, 15u, 16u, 17u, 99u, 100u, 101u, 4096u, 10007u}) {
    const Permutation p(size, 42);
    std::vector<bool> seen(size, false);
    for (std::uint64_t i = 0; i < size; ++i) {
      const std::uint64_t j = p.forward(i);
      ASSERT_LT(j, size);
      EXPECT_FALSE(seen[j]) << size;
      seen[j] = true;
      EXPECT_EQ(p.inverse(j), i);
    }
  }
}

TEST(Permutation, InvertsAtTheLargestSizes) {
  for (const std::uint64_t size :
       {Permutation::kMaxSize, Permutation::kMaxSize - 1, (std::uint64_t{1} << 40) + 12345}) {
    const Permutation p(size, 1);
    for (const std::uint64_t i : {std::uint64_t{0}, size / 3, size - 1}) {
      const std::uint64_t j = p.forward(i);
      EXPECT_LT(j, size);
      EXPECT_EQ(p.inverse(j), i);
    }
  }
}

TEST(Permutation, LeavesNothingInPlace) {
  constexpr std::uint64_t kSize = 100000;
  const Permutation p(kSize, 7);
  int fixed = 0, neighbours = 0;
  double distance = 0;
  for (std::uint64_t i = 0; i + 1 < kSize; ++i) {
    fixed += p.forward(i) == i;
    neighbours += p.forward(i + 1) == p.forward(i) + 1;
    const double a = static_cast<double>(p.forward(i)), b = static_cast<double>(p.forward(i + 1));
    distance += a < b ? b - a : a - b;
  }
  EXPECT_LT(fixed, 10);       // one is expected
  EXPECT_LT(neighbours, 10);  // one is expected
  EXPECT_NEAR(distance / kSize / kSize, 1.0 / 3, 0.01);
}

TEST(Permutation, DependsOnTheSeed) {
  const Permutation a(1000, 1), b(1000, 2);
  int same = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) same += a.forward(i) == b.forward(i);
  EXPECT_LT(same, 20);
}

}  // namespace
}  // namespace tetfusion
