#include "mesh/statistics.h"

#include <algorithm>
#include <cmath>

#include "base/blocks.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTuplesPerBlock = 1 << 16;

// Where the sum of squares is too large or too small for a double.
template <class T>
double length_of(std::span<const T> tuple) {
  double length = 0;
  for (const T x : tuple) length = std::hypot(length, static_cast<double>(x));
  return length;
}

template <class T>
void measure_tuple(std::span<const T> tuple, ArrayStatistics* s) {
  double square = 0;
  std::uint64_t non_finite = 0;
  for (const T value : tuple) {
    const auto x = static_cast<double>(value);
    square += x * x;
    if (!std::isfinite(x)) ++non_finite;
  }
  s->non_finite += non_finite;
  if (non_finite > 0) return;
  for (std::size_t k = 0; k < tuple.size(); ++k) {
    s->components[k].add(static_cast<double>(tuple[k]));
  }
  const double length = std::isnormal(square) ? std::sqrt(square) : length_of(tuple);
  // A finite tuple may be longer than what can be told.
  if (std::isfinite(length)) s->magnitude.add(length);
}

template <class T>
ArrayStatistics measure(std::span<const T> values, std::size_t width) {
  ArrayStatistics all;
  all.components.resize(width);
  if (width == 0) return all;
  const std::size_t tuples = values.size() / width;
  std::vector<ArrayStatistics> blocks(block_count(tuples, kTuplesPerBlock), all);
  for_each_block(tuples, kTuplesPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      measure_tuple(values.subspan(i * width, width), &blocks[b]);
    }
  });
  for (const ArrayStatistics& block : blocks) {
    all.add(block);
  }
  return all;
}

}  // namespace

void ArrayStatistics::add(const ArrayStatistics& other) {
  components.resize(std::max(components.size(), other.components.size()));
  for (std::size_t k = 0; k < other.components.size(); ++k) {
    components[k].add(other.components[k]);
  }
  magnitude.add(other.magnitude);
  non_finite += other.non_finite;
}

bool ArrayStatistics::constant() const {
  return non_finite == 0 && std::all_of(components.begin(), components.end(),
                                        [](const Range& r) { return !(r.max > r.min); });
}

double ArrayStatistics::diagonal() const {
  double length = 0;
  for (const Range& r : components) length = std::hypot(length, r.width());
  return length;
}

ArrayStatistics measure_array(const DataArray& array) {
  if (array.info.type == ValueType::kString) return {};
  return visit_type(array.info.type, [&](auto zero) {
    using T = decltype(zero);
    return measure<T>(array.as<T>(), array.info.components);
  });
}

}  // namespace tetfusion
