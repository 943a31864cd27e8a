// Sorting by whole numbers, where a comparison sort is not linear.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"

namespace tetfusion {

// Sorts by the lowest kBits bits of key(item): stable, least significant digit first. Digits that
// are the same in all keys are skipped. Needs room for the items once more.
template <int kBits, class Item, class Key>
void radix_sort(Vector<Item>* items, Key key) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;
  Vector<Item> other(items->size());
  for (int shift = 0; shift < kBits; shift += kDigitBits) {
    const auto digit = [&](const Item& item) {
      return static_cast<std::size_t>((key(item) >> shift) & (kBuckets - 1));
    };
    std::array<std::size_t, kBuckets> start{};
    for (const Item& item : *items) ++start[digit(item)];
    if (std::find(start.begin(), start.end(), items->size()) != start.end()) continue;
    std::size_t sum = 0;
    for (std::size_t& s : start) {
      const std::size_t count = s;
      s = sum;
      sum += count;
    }
    for (const Item& item : *items) other[start[digit(item)]++] = item;
    items->swap(other);
  }
}

}  // namespace tetfusion
