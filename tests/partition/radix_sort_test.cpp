#include "partition/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.h"

namespace tetfusion {
namespace {

struct Item {
  std::uint64_t key;
  std::uint32_t place;
  bool operator==(const Item&) const = default;
};

// Keys of up to `bits` bits, many of them equal.
Vector<Item> random_items(std::size_t count, int bits, std::uint64_t different) {
  Vector<Item> items;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pick = static_cast<std::uint64_t>(testing::uniform(7, i) * double(different));
    const auto key = (pick * 0x9E3779B97F4A7C15u) >> (64 - bits);
    items.push_back({key, static_cast<std::uint32_t>(i)});
  }
  return items;
}

template <int kBits>
void expect_sorted_like_stable_sort(std::size_t count, std::uint64_t different) {
  Vector<Item> items = random_items(count, kBits, different);
  Vector<Item> expected = items;
  std::ranges::stable_sort(expected, {}, &Item::key);
  radix_sort<kBits>(&items, [](const Item& i) { return i.key; });
  EXPECT_EQ(items, expected) << kBits << " bits, " << count << " items";
}

TEST(RadixSort, IsAStableSort) {
  for (const std::size_t count : {0, 1, 2, 100, 5000}) {
    for (const std::uint64_t different : {1, 2, 50, 1'000'000}) {
      expect_sorted_like_stable_sort<1>(count, different);
      expect_sorted_like_stable_sort<11>(count, different);
      expect_sorted_like_stable_sort<12>(count, different);
      expect_sorted_like_stable_sort<32>(count, different);
      expect_sorted_like_stable_sort<60>(count, different);
      expect_sorted_like_stable_sort<64>(count, different);
    }
  }
}

// Digits that all keys share are skipped, also in the middle.
TEST(RadixSort, SortsByDigitsThatDiffer) {
  Vector<std::uint64_t> keys;
  for (std::uint64_t i = 0; i < 100; ++i) {
    keys.push_back((i * 37 % 100) << 40 | std::uint64_t{5} << 20 | i % 3);
  }
  Vector<std::uint64_t> expected = keys;
  std::ranges::sort(expected);
  radix_sort<64>(&keys, [](std::uint64_t k) { return k; });
  EXPECT_EQ(keys, expected);
}

}  // namespace
}  // namespace tetfusion
