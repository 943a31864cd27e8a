#include "follow/fit_values.h"

#include <algorithm>
#include <cmath>

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

class Fitter {
 public:
  Fitter(const MapFile& map, std::size_t width, Vector<double>* values, const ReadRows& read)
      : map_(map), width_(width), values_(*values), read_(read) {
    find_new_points();
  }

  void run(double bound) {
    for (int i = 0; i < kSteps; ++i) {
      sweep([&](std::uint64_t point, const double* error) { add_error(point, error); });
    }
    if (!std::isfinite(bound)) return;
    bound_ = bound * range_.diagonal();
    for (int i = 0; i < kCorrections && is_possible_; ++i) {
      beyond_ = 0;
      sweep([&](std::uint64_t point, const double* error) { add_correction(point, error); });
      if (beyond_ == 0) return;
    }
  }

  Vector<std::uint8_t> take_new_points() { return std::move(is_new_); }

 private:
  void find_new_points() {
    is_new_.assign(map_.counts().points, 1);
    for (const MapShare& share : map_.shares()) {
      if (share.weight == 1) is_new_[share.point] = 0;
    }
    map_.forget(map_.shares());
  }

  // Calls add(point, error) for the original's points, in order, where there is an error; then
  // moves the values of new points by the means of what was added.
  template <class Add>
  void sweep(Add add) {
    sums_.assign(values_.size(), 0);
    weights_.assign(is_new_.size(), 0);
    Vector<double> errors;
    const bool first_time = range_.ranges.empty();
    if (first_time) range_.ranges.resize(width_);
    read_([&](std::uint64_t first, std::span<const double> rows) {
      const std::size_t count = rows.size() / width_;
      errors.resize(rows.size());
      for_each_block(count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          take_error(first + i, rows.data() + i * width_, errors.data() + i * width_);
        }
      });
      for (std::size_t i = 0; i < count; ++i) {
        const double* row = rows.data() + i * width_;
        if (map_.places()[first + i].cell == kNoCell || !all_finite(row, width_)) continue;
        if (first_time) range_.add(row);
        const double* error = errors.data() + i * width_;
        if (all_finite(error, width_)) add(first + i, error);
      }
      map_.forget(map_.places().subspan(first, count));
    });
    for (std::size_t v = 0; v < is_new_.size(); ++v) {
      if (!(weights_[v] > 0)) continue;
      for (std::size_t c = 0; c < width_; ++c) {
        values_[v * width_ + c] += sums_[v * width_ + c] / weights_[v];
      }
    }
  }

  void take_error(std::uint64_t point, const double* row, double* error) const {
    const MapPlace& place = map_.places()[point];
    if (place.cell == kNoCell) return;
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
      const auto v = static_cast<std::size_t>(corners[k]);
      if (place.weights[k] > 0 && is_new_[v] != 0) f(v, place.weights[k]);
    }
  }

  void add_error(std::uint64_t point, const double* error) {
    for_each_corner(point, [&](std::size_t v, double weight) {
      for (std::size_t c = 0; c < width_; ++c) sums_[v * width_ + c] += weight * error[c];
      weights_[v] += weight;
    });
  }

  // Each of the points by itself would be within the bound after its correction, the least there
  // is; together they take means, again and again.
  void add_correction(std::uint64_t point, const double* error) {
    double squares = 0;
    for (std::size_t c = 0; c < width_; ++c) squares += error[c] * error[c];
    const double length = std::sqrt(squares);
    if (!(length > kBeyond * bound_)) return;
    ++beyond_;
    double influence = 0;
    for_each_corner(point, [&](std::size_t, double weight) { influence += weight * weight; });
    if (influence < kNoInfluence) {
      is_possible_ = is_possible_ && length <= bound_;
      return;
    }
    const double share = (1 - kWithin * bound_ / length) / influence;
    for_each_corner(point, [&](std::size_t v, double weight) {
      for (std::size_t c = 0; c < width_; ++c) sums_[v * width_ + c] += weight * share * error[c];
      weights_[v] += 1;
    });
  }

  const MapFile& map_;
  const std::size_t width_;
  Vector<double>& values_;
  const ReadRows& read_;
  Vector<std::uint8_t> is_new_;
  Vector<double> sums_, weights_;
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
