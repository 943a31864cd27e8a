// From the numbers that a file gives its points and cells, in any order and with gaps, to their
// places in it.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/vector.h"

namespace tetfusion {

class NumberMap {
 public:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  NumberMap() = default;
  // numbers[i] leads to i; the first one is kept where there are two.
  explicit NumberMap(const Vector<std::uint64_t>& numbers);
  // Of first, first + 1, ...
  static NumberMap ascending(std::uint64_t first, std::uint64_t count);

  std::uint64_t find(std::uint64_t number) const;  // kNone where there is no such number
  bool has_twins() const { return has_twins_; }
  std::uint64_t twin() const { return twin_; }  // a number that is there twice
  // What it keeps: nothing for numbers that ascend by one.
  std::uint64_t bytes() const { return sorted_.size() * sizeof(sorted_[0]); }

 private:
  std::uint64_t first_ = 0;  // numbers ascend by one from here, if there is nothing below
  std::uint64_t count_ = 0;
  Vector<std::pair<std::uint64_t, std::uint64_t>> sorted_;  // number, place
  bool has_twins_ = false;
  std::uint64_t twin_ = 0;
};

}  // namespace tetfusion
