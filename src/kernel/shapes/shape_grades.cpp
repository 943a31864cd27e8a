#include "kernel/shapes/shape_grades.h"

#include <algorithm>
#include <bit>

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
  const double wanted = kLeeway * std::max(cubed_mean_ratio, 0.0);
  // The first that is no larger than that. As integers floating-point numbers are about their
  // logarithms.
  const auto logarithm = [](double x) { return std::bit_cast<std::int64_t>(x); };
  constexpr std::int64_t kLogarithmOfStep = std::int64_t{1} << 49;
  const std::int64_t about = (logarithm(floor()) - logarithm(wanted)) / kLogarithmOfStep;
  auto grade = static_cast<std::size_t>(std::clamp<std::int64_t>(about, 1, kCount - 1));
  while (grade > 1 && least_[grade - 1] <= wanted) --grade;
  while (grade + 1 < kCount && least_[grade] > wanted) ++grade;
  return static_cast<std::uint8_t>(grade);
}

}  // namespace tetfusion
