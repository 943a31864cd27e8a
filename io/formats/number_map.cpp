#include "io/formats/number_map.h"

#include <algorithm>

namespace tetfusion {

NumberMap::NumberMap(const Vector<std::uint64_t>& numbers) : count_(numbers.size()) {
  if (count_ == 0) return;
  first_ = numbers[0];
  std::uint64_t run = 0;
  while (run < count_ && numbers[run] == first_ + run) ++run;
  if (run == count_) return;
  sorted_.resize(count_);
  for (std::uint64_t i = 0; i < count_; ++i) sorted_[i] = {numbers[i], i};
  std::sort(sorted_.begin(), sorted_.end());
  for (std::uint64_t i = 1; i < count_ && !has_twins_; ++i) {
    has_twins_ = sorted_[i].first == sorted_[i - 1].first;
    twin_ = sorted_[i].first;
  }
}

NumberMap NumberMap::ascending(std::uint64_t first, std::uint64_t count) {
  NumberMap map;
  map.first_ = first;
  map.count_ = count;
  return map;
}

std::uint64_t NumberMap::find(std::uint64_t number) const {
  if (sorted_.empty())
    return number >= first_ && number - first_ < count_ ? number - first_ : kNone;
  const auto found =
      std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(number, std::uint64_t{0}));
  return found != sorted_.end() && found->first == number ? found->second : kNone;
}

}  // namespace tetfusion
