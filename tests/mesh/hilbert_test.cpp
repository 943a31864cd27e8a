#include "mesh/hilbert.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace tetfusion {
namespace {

struct Cell {
  int x, y, z;
};

TEST(Hilbert, VisitsEveryCellOnceAndStepsToAFaceNeighbour) {
  constexpr int kBits = 4;
  constexpr int kSide = 1 << kBits;
  std::map<std::uint64_t, Cell> along;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      for (int z = 0; z < kSide; ++z) {
        const auto at = [](int i) { return static_cast<std::uint32_t>(i); };
        along[hilbert_key(at(x), at(y), at(z), kBits)] = {x, y, z};
      }
    }
  }
  ASSERT_EQ(along.size(), std::size_t{kSide} * kSide * kSide);
  EXPECT_EQ(along.begin()->first, 0u);
  EXPECT_EQ(along.rbegin()->first, along.size() - 1);
  for (auto a = along.begin(), b = std::next(a); b != along.end(); ++a, ++b) {
    const int step = std::abs(a->second.x - b->second.x) + std::abs(a->second.y - b->second.y) +
                     std::abs(a->second.z - b->second.z);
    ASSERT_EQ(step, 1) << "after key " << a->first;
  }
}

TEST(Hilbert, FinerCellsLieInTheCoarseOnesOfTheirKey) {
  constexpr std::uint32_t kX = 9, kY = 3, kZ = 14;
  constexpr int kShift = kHilbertBits - 4;
  EXPECT_EQ(hilbert_key(kX << kShift, kY << kShift, kZ << kShift) >> (3 * kShift),
            hilbert_key(kX, kY, kZ, 4));
}

TEST(Hilbert, UsesAllBits) {
  constexpr std::uint32_t kLast = (1u << kHilbertBits) - 1;
  EXPECT_NE(hilbert_key(0, 0, 0), hilbert_key(0, 0, 1));
  EXPECT_LT(hilbert_key(kLast, kLast, kLast), std::uint64_t{1} << (3 * kHilbertBits));
}

}  // namespace
}  // namespace tetfusion
