#include "kernel/shapes/shape_grades.h"

#include <algorithm>
#include <functional>

namespace tetfusion {

namespace {

constexpr double kStep = 0.917004043204671;  // an eighth of an octave, as mean ratios are cubed
constexpr double kLeeway = 0.978 * 0.978 * 0.978;

}  // namespace

ShapeGrades::ShapeGrades(double floor) {
  least_.front() = floor * floor * floor;
  for (std::size_t i = 1; i + 1 < kCount; ++i) least_[i] = kStep * least_[i - 1];
  least_.back() = 0;
}

std::uint8_t ShapeGrades::grade_of(double cubed_mean_ratio) const {
  if (cubed_mean_ratio >= floor()) return 0;
  const double wanted = kLeeway * cubed_mean_ratio;
  const auto grade =
      std::lower_bound(least_.begin() + 1, least_.end() - 1, wanted, std::greater<>());
  return static_cast<std::uint8_t>(grade - least_.begin());
}

}  // namespace tetfusion
