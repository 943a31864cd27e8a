#include "io/source/differing_copies.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/blocks.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kPointsAtOnce = std::uint64_t{1} << 16;
constexpr std::size_t kCopiesPerBlock = 4096;
constexpr std::uint64_t kLeastRows = std::uint64_t{4} << 20;  // bytes
constexpr std::uint64_t kRowBytesPerPoint = 2;

bool bit_of(std::span<const std::uint64_t> bits, std::uint64_t i) {
  return (bits[i / 64] >> (i % 64) & 1) != 0;
}

template <class T>
bool is_same_value(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(a) && std::isnan(b)) return true;
  }
  return a == b;
}

// 0 where one of them is not finite.
template <class T>
double distance_of(const T* a, const T* b, std::size_t components) {
  double distance = 0;
  for (std::size_t k = 0; k < components; ++k) {
    distance = std::hypot(distance, static_cast<double>(a[k]) - static_cast<double>(b[k]));
  }
  return std::isfinite(distance) ? distance : 0;
}

// Ascending, each of them once.
Vector<VertexId> originals_of(const JoinedPoints& points) {
  Vector<std::uint64_t> bits;
  bits.assign(points.stay.size(), 0);
  for (const PointCopy& copy : points.copies) {
    bits[copy.original / 64] |= std::uint64_t{1} << (copy.original % 64);
  }
  std::size_t count = 0;
  for (const std::uint64_t word : bits) count += static_cast<std::size_t>(std::popcount(word));
  Vector<VertexId> originals;
  originals.reserve(count);
  for (std::size_t w = 0; w < bits.size(); ++w) {
    for (std::uint64_t word = bits[w]; word != 0; word &= word - 1) {
      originals.push_back(
          static_cast<VertexId>(64 * w + static_cast<std::uint64_t>(std::countr_zero(word))));
    }
  }
  return originals;
}

class CopyComparer {
 public:
  CopyComparer(const JoinedPoints& points, std::span<const ArrayInfo> arrays,
               const ReadPointRows& read)
      : points_(points), arrays_(arrays), read_(read), originals_(originals_of(points)) {
    differs_.assign(points.copies.size(), 0);
  }

  CopyDifferences run() {
    CopyDifferences out;
    bool of_floats = false;
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      if (is_ghost_mark(arrays_[i].name)) continue;
      const double largest =
          visit_type(arrays_[i].type, [&](auto zero) { return compare<decltype(zero)>(i); });
      const bool floats = is_float(arrays_[i].type);
      if (largest == 0 || (of_floats && !floats)) continue;
      const double range =
          visit_type(arrays_[i].type, [&](auto zero) { return range_of<decltype(zero)>(i); });
      const double share = largest / range;
      if (!std::isfinite(share) || (of_floats == floats && share <= out.largest.share)) continue;
      out.largest = {i, share};
      of_floats = floats;
    }
    out.points = static_cast<std::uint64_t>(std::count(differs_.begin(), differs_.end(), 1));
    return out;
  }

 private:
  // The largest distance between a copy's finite values and its original's.
  template <class T>
  double compare(std::size_t array) {
    const std::uint64_t most = std::max(kLeastRows, kRowBytesPerPoint * 64 * points_.stay.size());
    const std::uint64_t row = arrays_[array].components * sizeof(T);
    const std::uint64_t fit = std::max<std::uint64_t>(1, most / row);
    double largest = 0;
    for (std::size_t first = 0; first < originals_.size(); first += fit) {
      const auto count = std::min<std::size_t>(fit, originals_.size() - first);
      largest =
          std::max(largest, compare_some<T>(array, std::span(originals_).subspan(first, count)));
    }
    return largest;
  }

  // The same of the copies of some originals, window by window.
  template <class T>
  double compare_some(std::size_t array, std::span<const VertexId> originals) {
    const std::size_t width = arrays_[array].components;
    Taken<T> taken{originals, Vector<T>(originals.size() * width)};
    double largest = 0;
    std::size_t o = 0, c = 0;
    // No copy comes before its original.
    while (c < points_.copies.size() && points_.copies[c].point < originals.front()) ++c;
    while (c < points_.copies.size()) {
      VertexId first = points_.copies[c].point;
      if (o < originals.size()) first = std::min(first, originals[o]);
      const std::uint64_t end = (first / kPointsAtOnce + 1) * kPointsAtOnce;
      std::uint64_t last = first;
      std::size_t next_o = o, next_c = c;
      while (next_o < originals.size() && originals[next_o] < end) last = originals[next_o++];
      while (next_c < points_.copies.size() && points_.copies[next_c].point < end) ++next_c;
      if (next_c > c) last = std::max<std::uint64_t>(last, points_.copies[next_c - 1].point);
      const auto rows = read_(array, first, last + 1 - first);
      const Rows<T> window{first, width, reinterpret_cast<const T*>(rows.data())};
      for (; o < next_o; ++o) {
        std::copy_n(window.of(originals[o]), width, taken.values.data() + o * width);
      }
      largest = std::max(largest, compare_copies(c, next_c, window, taken));
      c = next_c;
    }
    return largest;
  }

  template <class T>
  struct Rows {
    std::uint64_t first;
    std::size_t width;
    const T* values;
    const T* of(VertexId point) const { return values + (point - first) * width; }
  };
  template <class T>
  struct Taken {
    std::span<const VertexId> points;  // ascending
    Vector<T> values;
  };

  // The same of the copies from `begin` to `end`, which lie in the window; those of other originals
  // do not count.
  template <class T>
  double compare_copies(std::size_t begin, std::size_t end, const Rows<T>& window,
                        const Taken<T>& taken) {
    const std::size_t width = window.width;
    std::vector<double> largest_of(block_count(end - begin, kCopiesPerBlock), 0);
    for_each_block(
        end - begin, kCopiesPerBlock, [&](std::size_t block, std::size_t from, std::size_t to) {
          for (std::size_t i = begin + from; i < begin + to; ++i) {
            const PointCopy copy = points_.copies[i];
            const auto at =
                std::lower_bound(taken.points.begin(), taken.points.end(), copy.original);
            if (at == taken.points.end() || *at != copy.original) continue;
            const T* const own = window.of(copy.point);
            const T* const other =
                taken.values.data() + static_cast<std::size_t>(at - taken.points.begin()) * width;
            if (std::equal(own, own + width, other, is_same_value<T>)) continue;
            differs_[i] = 1;
            largest_of[block] = std::max(largest_of[block], distance_of(own, other, width));
          }
        });
    double largest = 0;
    for (const double of_block : largest_of) largest = std::max(largest, of_block);
    return largest;
  }

  // The diagonal of the box of all finite values that points have, copies too.
  template <class T>
  double range_of(std::size_t array) {
    const std::size_t width = arrays_[array].components;
    std::vector<double> low(width, std::numeric_limits<double>::infinity());
    std::vector<double> high(width, -std::numeric_limits<double>::infinity());
    std::size_t c = 0;
    const std::uint64_t points = arrays_[array].tuples;
    for (std::uint64_t first = 0; first < points; first += kPointsAtOnce) {
      const std::uint64_t count = std::min(kPointsAtOnce, points - first);
      const auto rows = read_(array, first, count);
      const T* const values = reinterpret_cast<const T*>(rows.data());
      for (std::uint64_t i = 0; i < count; ++i) {
        const bool is_copy = c < points_.copies.size() && points_.copies[c].point == first + i;
        if (is_copy) ++c;
        if (!is_copy && !bit_of(points_.stay, first + i)) continue;
        for (std::size_t k = 0; k < width; ++k) {
          const auto value = static_cast<double>(values[i * width + k]);
          if (!std::isfinite(value)) continue;
          low[k] = std::min(low[k], value);
          high[k] = std::max(high[k], value);
        }
      }
    }
    double range = 0;
    for (std::size_t k = 0; k < width; ++k) {
      if (low[k] < high[k]) range = std::hypot(range, high[k] - low[k]);
    }
    return range;
  }

  const JoinedPoints& points_;
  std::span<const ArrayInfo> arrays_;
  const ReadPointRows& read_;
  Vector<VertexId> originals_;
  Vector<std::uint8_t> differs_;  // for each copy
};

}  // namespace

CopyDifferences find_differences(const JoinedPoints& points, std::span<const ArrayInfo> arrays,
                                 const ReadPointRows& read) {
  if (points.copies.empty()) return {};
  return CopyComparer(points, arrays, read).run();
}

CopyDifferences find_differences(const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used,
                                 std::span<const ArrayInfo> arrays, const ReadPointRows& read) {
  Vector<std::uint64_t> stay;
  stay.assign(block_count(copy_of.size(), 64), 0);
  std::size_t count = 0;
  for (std::size_t v = 0; v < copy_of.size(); ++v) count += copy_of[v] != v ? 1 : 0;
  Vector<PointCopy> copies;
  copies.reserve(count);
  for (std::size_t v = 0; v < copy_of.size(); ++v) {
    if (copy_of[v] != v) {
      copies.push_back({static_cast<VertexId>(v), copy_of[v]});
    } else if (used[v] != 0) {
      stay[v / 64] |= std::uint64_t{1} << (v % 64);
    }
  }
  return find_differences({stay, copies}, arrays, read);
}

namespace {

ArrayInfo coordinates(ValueType type, std::uint64_t tuples) {
  ArrayInfo info;
  info.type = type;
  info.components = 3;
  info.tuples = tuples;
  return info;
}

bool are_near(const CopyDifferences& differences) {
  constexpr double kRounding = 1e-5;
  return differences.largest.share <= kRounding;
}

}  // namespace

bool lie_together(const JoinedPoints& points, ValueType point_type, std::uint64_t tuples,
                  const ReadPointRows& read) {
  const ArrayInfo info = coordinates(point_type, tuples);
  return are_near(find_differences(points, {&info, 1}, read));
}

bool lie_together(const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used,
                  const Points& positions) {
  return std::visit(
      [&](const auto& p) {
        using Real = std::remove_cvref_t<decltype(p[0].x)>;
        const auto read = [&](std::size_t, std::uint64_t first, std::uint64_t count) {
          return std::as_bytes(std::span(p).subspan(first, count));
        };
        const ArrayInfo info = coordinates(value_type_of<Real>(), p.size());
        return are_near(find_differences(copy_of, used, {&info, 1}, read));
      },
      positions);
}

}  // namespace tetfusion
