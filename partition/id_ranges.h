// What many have to say of the same ids, brought together without all of it being there twice.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vector.h"
#include "partition/radix_sort.h"

namespace tetfusion {

template <class Item>
void sort_by_id(Vector<Item>* items) {
  radix_sort<32>(items, [](const Item& item) { return item.id; });
  items->shrink_to_fit();
}

// In each part items ascend by Item::id. Calls use(items) for one range of ids after the other,
// ascending, with what all parts have in it: ascending by id, and by part where ids are the same.
// Parts are freed as they are used up.
template <class Item, class Use>
void for_each_id_range(std::vector<Vector<Item>> parts, Use use,
                       std::size_t items_at_once = std::size_t{1} << 18) {
  std::erase_if(parts, [](const Vector<Item>& part) { return part.empty(); });
  std::size_t all = 0;
  std::uint64_t ids = 0;
  for (const Vector<Item>& part : parts) {
    all += part.size();
    ids = std::max(ids, std::uint64_t{part.back().id} + 1);
  }
  const std::uint64_t ranges = all / items_at_once + 1;
  std::vector<std::size_t> next(parts.size());
  Vector<Item> window;
  for (std::uint64_t r = 1; r <= ranges; ++r) {
    const std::uint64_t end = ids * r / ranges;
    window.clear();
    for (std::size_t p = 0; p < parts.size(); ++p) {
      Vector<Item>& part = parts[p];
      std::size_t& i = next[p];
      for (; i < part.size() && part[i].id < end; ++i) window.push_back(part[i]);
      if (i == part.size()) part = {};
    }
    sort_by_id(&window);
    use(window);
  }
}

}  // namespace tetfusion
