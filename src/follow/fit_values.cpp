#include "follow/fit_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "compare/measure.h"
#include "mesh/blocks.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlock = 8192;
// Steps towards the least squares: the first one takes away most of what can be, a fourth one
// nothing that could be measured (README.md).
constexpr int kSteps = 3;
// Corrections of what is beyond the bound: most take fewer than ten, and what forty do not bring in
// no more do.
constexpr int kCorrections = 40;
// Errors beyond the first share of the bound are brought to the second, so that what rounding does
// to the values stays within.
constexpr double kBeyond = 0.99, kWithin = 0.97;
// Squares of weights: a point that depends less on new points cannot be helped by them.
constexpr double kNoInfluence = 1e-9;

// Vertices are in so many ranges, each of which one thread takes at a time; and so many points of
// the original are taken before their parts are added up.
constexpr std::size_t kRanges = 32;
constexpr std::size_t kSlice = 8 * kBlock;

class Fitter {
 public:
  Fitter(const MapFile& map, std::size_t width, Vector<double>* values, const ReadRows& read)
      : map_(map), width_(width), values_(*values), read_(read) {
    find_new_points();
  }

  void run(double bound) {
    for (int i = 0; i < kSteps; ++i) {
      sweep([&](std::uint64_t point, const double*, Block* block) { add_error(point, block); });
    }
    if (!std::isfinite(bound)) return;
    bound_ = bound * range_.diagonal();
    for (int i = 0; i < kCorrections && is_possible_; ++i) {
      beyond_ = 0;
      sweep([&](std::uint64_t point, const double* error, Block* block) {
        add_correction(point, error, block);
      });
      if (beyond_ == 0) return;
    }
  }

  Vector<std::uint8_t> take_new_points() { return std::move(is_new_); }

 private:
  // What a point does to a new one: factor times its error, with a weight.
  struct Part {
    std::uint32_t to = 0;
    std::uint32_t from = 0;  // counted from the window's first point
    double factor = 0;
    double weight = 0;
  };
  // What a block of the original's points has to say.
  struct Block {
    std::uint32_t from = 0;                       // the point in hand
    std::vector<Part> parts, sorted;              // in order; and by ranges
    std::array<std::size_t, kRanges + 1> ends{};  // of ranges in these, from the second on
    FieldValues range;
    std::uint64_t beyond = 0;
    bool is_possible = true;
  };

  void find_new_points() {
    is_new_.assign(map_.counts().points, 1);
    for (const MapShare& share : map_.shares()) {
      if (share.weight == 1) is_new_[share.point] = 0;
    }
    map_.forget(map_.shares());
  }

  // Calls add(point, error, block) for the original's points where there is an error, from several
  // threads; then moves the values of new points by the means of what was added, in the order of
  // the points whatever the threads.
  template <class Add>
  void sweep(Add add) {
    sums_.assign(values_.size(), 0);
    weights_.assign(is_new_.size(), 0);
    const bool first_time = range_.ranges.empty();
    if (first_time) range_.ranges.resize(width_);
    read_([&](std::uint64_t first, std::span<const double> rows) {
      const std::size_t count = rows.size() / width_;
      errors_.resize(rows.size());
      for (std::size_t begin = 0; begin < count; begin += kSlice) {
        take_slice(first, begin, std::min(begin + kSlice, count), rows.data(), first_time, add);
        add_parts();
      }
      map_.forget(map_.places().subspan(first, count));
    });
    for_each_block(is_new_.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (!(weights_[v] > 0)) continue;
        for (std::size_t c = 0; c < width_; ++c) {
          values_[v * width_ + c] += sums_[v * width_ + c] / weights_[v];
        }
      }
    });
  }

  // Points [from, to) of the window whose first one is that.
  template <class Add>
  void take_slice(std::uint64_t first, std::size_t from, std::size_t to, const double* rows,
                  bool first_time, Add add) {
    blocks_.resize(block_count(to - from, kBlock));
    for_each_block(to - from, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
      Block& block = blocks_[b];
      block.parts.clear();
      block.range = {std::vector<Range>(width_), 0};
      block.beyond = 0;
      for (std::size_t i = from + begin; i < from + end; ++i) {
        const double* row = rows + i * width_;
        double* error = errors_.data() + i * width_;
        if (map_.places()[first + i].cell == kNoCell || !all_finite(row, width_)) continue;
        if (first_time) block.range.add(row);
        take_error(first + i, row, error);
        block.from = static_cast<std::uint32_t>(i);
        if (all_finite(error, width_)) add(first + i, error, &block);
      }
      sort_parts(&block);
    });
    for (const Block& block : blocks_) {
      if (first_time) range_.add(block.range);
      beyond_ += block.beyond;
      is_possible_ = is_possible_ && block.is_possible;
    }
  }

  std::size_t range_of(std::uint32_t vertex) const {
    return std::size_t{vertex} * kRanges / is_new_.size();
  }

  void sort_parts(Block* block) const {
    std::array<std::size_t, kRanges + 1>& ends = block->ends;
    ends.fill(0);
    for (const Part& part : block->parts) ++ends[range_of(part.to) + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::array<std::size_t, kRanges + 1> next = ends;
    block->sorted.resize(block->parts.size());
    for (const Part& part : block->parts) block->sorted[next[range_of(part.to)]++] = part;
  }

  void add_parts() {
    for_each_block(kRanges, 1, [&](std::size_t r, std::size_t, std::size_t) {
      for (const Block& block : blocks_) {
        for (std::size_t i = block.ends[r]; i < block.ends[r + 1]; ++i) {
          const Part& part = block.sorted[i];
          const double* error = errors_.data() + part.from * width_;
          double* sum = sums_.data() + part.to * width_;
          for (std::size_t c = 0; c < width_; ++c) sum[c] += part.factor * error[c];
          weights_[part.to] += part.weight;
        }
      }
    });
  }

  void take_error(std::uint64_t point, const double* row, double* error) const {
    const MapPlace& place = map_.places()[point];
    const auto corners = map_.corners(place.cell);
    for (std::size_t c = 0; c < width_; ++c) {
      double value = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        if (place.weights[k] == 0) continue;
        value += place.weights[k] * values_[static_cast<std::size_t>(corners[k]) * width_ + c];
      }
      error[c] = row[c] - value;
    }
  }

  // Calls f(new point, weight) for the corners that the point depends on.
  template <class F>
  void for_each_corner(std::uint64_t point, F f) const {
    const MapPlace& place = map_.places()[point];
    const auto corners = map_.corners(place.cell);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto v = static_cast<std::uint32_t>(corners[k]);
      if (place.weights[k] > 0 && is_new_[v] != 0) f(v, place.weights[k]);
    }
  }

  void add_error(std::uint64_t point, Block* block) const {
    for_each_corner(point, [&](std::uint32_t v, double weight) {
      block->parts.push_back({v, block->from, weight, weight});
    });
  }

  // Each of the points by itself would be within the bound after its correction, the least there
  // is; together they take means, again and again.
  void add_correction(std::uint64_t point, const double* error, Block* block) const {
    double squares = 0;
    for (std::size_t c = 0; c < width_; ++c) squares += error[c] * error[c];
    const double length = std::sqrt(squares);
    if (!(length > kBeyond * bound_)) return;
    ++block->beyond;
    double influence = 0;
    for_each_corner(point, [&](std::uint32_t, double weight) { influence += weight * weight; });
    if (influence < kNoInfluence) {
      block->is_possible = block->is_possible && length <= bound_;
      return;
    }
    const double share = (1 - kWithin * bound_ / length) / influence;
    for_each_corner(point, [&](std::uint32_t v, double weight) {
      block->parts.push_back({v, block->from, weight * share, 1});
    });
  }

  const MapFile& map_;
  const std::size_t width_;
  Vector<double>& values_;
  const ReadRows& read_;
  Vector<std::uint8_t> is_new_;
  Vector<double> sums_, weights_;
  Vector<double> errors_;  // of the window in hand
  std::vector<Block> blocks_;
  FieldValues range_;  // of the original's values, from the first sweep on
  double bound_ = 0;
  std::uint64_t beyond_ = 0;
  bool is_possible_ = true;
};

}  // namespace

Vector<std::uint8_t> fit_values(const MapFile& map, std::size_t width, double bound,
                                Vector<double>* values, const ReadRows& read) {
  Fitter fitter(map, width, values, read);
  fitter.run(bound);
  return fitter.take_new_points();
}

}  // namespace tetfusion
