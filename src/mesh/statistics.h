// The values of an array at a glance.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/data_array.h"

namespace tetfusion {

// Over finite values; min > max where there are none. 64-bit integers beyond 2^53 are rounded.
struct Range {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  bool empty() const { return min > max; }
  double width() const { return empty() ? 0 : max - min; }
  void add(double x) {
    if (x < min) min = x;
    if (x > max) max = x;
  }
  void add(const Range& r) {
    if (r.empty()) return;  // its ends are no values
    add(r.min);
    add(r.max);
  }
};

struct ArrayStatistics {
  // Of tuples whose values are all finite: one for each component, and their Euclidean length.
  std::vector<Range> components;
  Range magnitude;
  std::uint64_t non_finite = 0;  // values

  // Of the rows of both.
  void add(const ArrayStatistics& other);
  // Every component has one value at most, and that everywhere.
  bool constant() const;
  // Of the box of the components: what errors in the array are shares of.
  double diagonal() const;
};

// Empty for an array of strings. Deterministic for any number of threads.
ArrayStatistics measure_array(const DataArray& array);

}  // namespace tetfusion
