// A part of an array of several dimensions: so many rows from one on, each so many behind the last
// one, along every dimension. The last dimension runs fastest.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tetfusion {

using Dimensions = std::vector<std::uint64_t>;

// How many values there are; nothing where they are more than can be counted.
std::optional<std::uint64_t> value_count(const Dimensions& dimensions);

// "3 x 4"
std::string extent_words(const Dimensions& dimensions);

struct Hyperslab {
  Dimensions start, stride, count;  // of one length

  // Does it lie in an array of these dimensions, which are as many?
  bool lies_in(const Dimensions& dimensions) const;
};

// Calls f(first value in the array, how many) for runs of values that follow one another, in their
// order. The slab lies in an array of these dimensions, and the values of both can be counted.
template <class F>
void for_each_run(const Dimensions& dimensions, const Hyperslab& slab, F f) {
  if (value_count(slab.count) == std::uint64_t{0}) return;
  const std::size_t last = dimensions.size() - 1;
  const bool is_dense = slab.stride[last] == 1;
  Dimensions at(dimensions.size(), 0);
  for (;;) {
    std::uint64_t first = 0;
    for (std::size_t d = 0; d <= last; ++d) {
      first = first * dimensions[d] + slab.start[d] + at[d] * slab.stride[d];
    }
    f(first, is_dense ? slab.count[last] : 1);
    std::size_t d = last;
    if (is_dense) at[last] = slab.count[last] - 1;
    while (++at[d] == slab.count[d]) {
      at[d] = 0;
      if (d-- == 0) return;
    }
  }
}

}  // namespace tetfusion
