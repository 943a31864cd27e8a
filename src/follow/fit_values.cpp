#include "follow/fit_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/blocks.h"
#include "base/resources.h"
#include "compare/measure.h"

namespace tetfusion {

namespace {

constexpr std::size_t kPlacesPerBlock = 8192;
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

class Fitter {
 public:
  Fitter(const PointWeights& weights, std::size_t width, Vector<double>* values,
         const ReadRows& read)
      : weights_(weights), width_(width), values_(*values), read_(read) {}

  void run(double bound) {
    range_.ranges.resize(width_);
    for (int i = 0; i < kSteps; ++i) {
      sweep([&](std::size_t window, const double* rows) {
        if (loop_threads() == 1) {
          take_and_add_errors(window, rows, i == 0);
        } else {
          take_errors(window, rows, i == 0);
          add_errors(window);
        }
      });
    }
    if (!std::isfinite(bound)) return;
    bound_ = bound * range_.diagonal();
    for (int i = 0; i < kCorrections && is_possible_; ++i) {
      beyond_ = 0;
      sweep([&](std::size_t window, const double* rows) {
        take_errors(window, rows, false);
        add_corrections(window);
      });
      if (beyond_ == 0) return;
    }
  }

 private:
  // What a point beyond the bound does to a new one: factor times its error.
  struct Correction {
    VertexId to = 0;
    std::size_t from = 0;  // counted from the window's first point
    double factor = 0;
  };
  // What a block of a window's points has to say.
  struct Block {
    std::vector<Correction> corrections;
    std::uint64_t beyond = 0;
    bool is_possible = true;
  };

  // Calls add(window, rows), which adds to the sums and counts what errors say; then moves the
  // values of new points by the means, but none out of the range of the original's.
  template <class Add>
  void sweep(Add add) {
    const std::size_t points = weights_.is_new().size();
    sums_.assign(values_.size(), 0);
    counts_.assign(points, 0);
    read_([&](std::uint64_t first, std::span<const double> rows) {
      const std::size_t count = rows.size() / width_;
      for (std::size_t begin = 0; begin < count; begin += PointWeights::kWindow) {
        add((first + begin) / PointWeights::kWindow, rows.data() + begin * width_);
      }
      weights_.let_go();
    });
    for_each_block(points, kPlacesPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (!(counts_[v] > 0)) continue;
        for (std::size_t c = 0; c < width_; ++c) {
          double& value = values_[v * width_ + c];
          const auto [least, most] =
              std::minmax({range_.ranges[c].min, range_.ranges[c].max, value});
          value = std::clamp(value + sums_[v * width_ + c] / counts_[v], least, most);
        }
      }
    });
  }

  void take_errors(std::size_t window, const double* rows, bool first_time) {
    const auto places = weights_.places(window);
    errors_.resize(places.size() * width_);
    std::vector<FieldValues> ranges(block_count(places.size(), kPlacesPerBlock));
    for_each_block(places.size(), kPlacesPerBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     ranges[b].ranges.resize(width_);
                     for (std::size_t i = begin; i < end; ++i) {
                       take_error(places[i], rows + i * width_, errors_.data() + i * width_,
                                  first_time ? &ranges[b] : nullptr);
                     }
                   });
    if (!first_time) return;
    for (const FieldValues& range : ranges) range_.add(range);
  }

  // By one thread both are done at once, with the same sums: a new point's parts are in the order
  // of the points either way.
  void take_and_add_errors(std::size_t window, const double* rows, bool first_time) {
    errors_.resize(width_);
    double* error = errors_.data();
    for (const PointPlace& place : weights_.places(window)) {
      take_error(place, rows, error, first_time ? &range_ : nullptr);
      rows += width_;
      if (std::isnan(error[0])) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        const VertexId to = place.corners[k];
        if (!(place.weights[k] > 0) || weights_.is_new()[to] == 0) continue;
        double* sum = sums_.data() + to * width_;
        for (std::size_t c = 0; c < width_; ++c) sum[c] += place.weights[k] * error[c];
        counts_[to] += place.weights[k];
      }
    }
  }

  // The first component is not a number where there is no error. `range` may be null.
  void take_error(const PointPlace& place, const double* row, double* error,
                  FieldValues* range) const {
    error[0] = std::numeric_limits<double>::quiet_NaN();
    if (place.corners[0] == kNoVertex || !all_finite(row, width_)) return;
    if (range != nullptr) range->add(row);
    for (std::size_t c = 0; c < width_; ++c) {
      double value = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        value += place.weights[k] * values_[place.corners[k] * width_ + c];
      }
      error[c] = row[c] - value;
    }
    if (!all_finite(error, width_)) error[0] = std::numeric_limits<double>::quiet_NaN();
  }

  // In the order of the points for each new one, whatever the threads.
  void add_errors(std::size_t window) {
    for_each_block(PointWeights::kRanges, 1, [&](std::size_t r, std::size_t, std::size_t) {
      for (const PointWeights::Part& part : weights_.parts(window, r)) {
        const double* error = errors_.data() + part.from * width_;
        if (std::isnan(error[0])) continue;
        double* sum = sums_.data() + part.to * width_;
        for (std::size_t c = 0; c < width_; ++c) sum[c] += part.weight * error[c];
        counts_[part.to] += part.weight;
      }
    });
  }

  void add_corrections(std::size_t window) {
    const auto places = weights_.places(window);
    std::vector<Block> blocks(block_count(places.size(), kPlacesPerBlock));
    for_each_block(places.size(), kPlacesPerBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin; i < end; ++i)
                       find_correction(places[i], i, &blocks[b]);
                   });
    for (const Block& block : blocks) {
      beyond_ += block.beyond;
      is_possible_ = is_possible_ && block.is_possible;
      for (const Correction& correction : block.corrections) {
        const double* error = errors_.data() + correction.from * width_;
        double* sum = sums_.data() + correction.to * width_;
        for (std::size_t c = 0; c < width_; ++c) sum[c] += correction.factor * error[c];
        counts_[correction.to] += 1;
      }
    }
  }

  // Each of the points by itself would be within the bound after its correction, the least there
  // is; together they take means, again and again.
  void find_correction(const PointPlace& place, std::size_t point, Block* block) const {
    const double* error = errors_.data() + point * width_;
    double squares = 0;
    for (std::size_t c = 0; c < width_; ++c) squares += error[c] * error[c];
    const double length = std::sqrt(squares);
    if (!(length > kBeyond * bound_)) return;
    ++block->beyond;
    double influence = 0;
    const auto for_each_corner = [&](auto f) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (place.weights[k] > 0 && weights_.is_new()[place.corners[k]] != 0) f(k);
      }
    };
    for_each_corner([&](std::size_t k) { influence += place.weights[k] * place.weights[k]; });
    if (influence < kNoInfluence) {
      block->is_possible = block->is_possible && length <= bound_;
      return;
    }
    const double share = (1 - kWithin * bound_ / length) / influence;
    for_each_corner([&](std::size_t k) {
      block->corrections.push_back({place.corners[k], point, place.weights[k] * share});
    });
  }

  const PointWeights& weights_;
  const std::size_t width_;
  Vector<double>& values_;
  const ReadRows& read_;
  Vector<double> sums_, counts_;  // of each point of the result
  Vector<double> errors_;         // of the window in hand, or a point of it
  FieldValues range_;             // of the original's values
  double bound_ = 0;
  std::uint64_t beyond_ = 0;
  bool is_possible_ = true;
};

}  // namespace

void fit_values(const PointWeights& weights, std::size_t width, double bound,
                Vector<double>* values, const ReadRows& read) {
  Fitter(weights, width, values, read).run(bound);
}

}  // namespace tetfusion
