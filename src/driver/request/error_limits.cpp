#include "driver/request/error_limits.h"

#include <algorithm>

namespace tetfusion {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The cost of a fusion is a mean of squares over what the vertex stands for, whose linear functions
// it takes far beyond their tetrahedra. Fusions that cost up to 16, 64, 256 or 4096 times the
// square of a bound of 0.1 % reach 79.7, 81.8, 83.1 and 83.2 % on the Delaunay ball
// (bench/README.md), 52.3, 53.0, 53.1 and 53.2 % on the blunt fin; with 1 % sixteen times do.
constexpr double kHopeless = 256;
// Where a field is linear a fusion costs what its edge does (kernel/quadrics/edge_costs.cpp), and
// is allowed for any bound.
constexpr double kEdge = 1e-6;

// As values stay within the range of their field, or nearly so.
constexpr double kAnything = 2;

// So much of a squared bound at most is the gradients' variance to cost.
constexpr double kVarianceOfBound = 1.0 / 64;

// Infinite without fields.
double squared_limits(const Tolerances& tolerances, double max_error) {
  double squares = 0;
  for (const auto& tolerance : tolerances) {
    const double limit = tolerance.value_or(max_error);
    squares += limit * limit;
  }
  return tolerances.empty() ? kInfinity : squares;
}

}  // namespace

Tolerances tolerances_of(std::span<const SteeringField> fields) {
  Tolerances tolerances;
  for (const SteeringField& field : fields) tolerances.push_back(field.tolerance);
  return tolerances;
}

bool is_on(const std::vector<double>& values) {
  return std::ranges::any_of(values, [](double value) { return value < kInfinity; });
}

FusionErrors noted_errors(const BehaviourOptions& options, const Tolerances& tolerances) {
  if (options.method != Method::kFuse || tolerances.empty()) return FusionErrors::kNone;
  const double all = error_limits(options, tolerances).max_error;
  const bool at_points = std::ranges::all_of(
      tolerances, [&](const auto& tolerance) { return tolerance.value_or(all) < kInfinity; });
  return at_points ? FusionErrors::kLargest : FusionErrors::kMean;
}

bool limits_errors(const BehaviourOptions& options, const Tolerances& tolerances) {
  if (tolerances.empty()) return false;
  return options.method != Method::kFuse || options.max_rms || is_on(options.scalar_tolerance) ||
         error_limits(options, tolerances).at_points;
}

ErrorLimits error_limits(const BehaviourOptions& options, const Tolerances& tolerances) {
  ErrorLimits limits;
  limits.have_fields = !tolerances.empty();
  if (options.method != Method::kFuse) return limits;
  const bool own =
      std::ranges::any_of(tolerances, [](const auto& tolerance) { return tolerance.has_value(); });
  const bool has_goal = options.reduction || options.tets || !options.lods.empty();
  const bool by_default = !has_goal && !options.max_rms && !own;
  limits.max_error = options.max_error.value_or(by_default ? kDefaultMaxError : kInfinity);
  limits.at_points = !tolerances.empty() && (own || limits.max_error < kInfinity);
  limits.rise = limits.at_points && has_goal;
  for (const auto& tolerance : tolerances) {
    limits.highest =
        std::max(limits.highest, std::min(tolerance.value_or(limits.max_error), kAnything));
  }
  // Without fields a fusion costs what its edge does.
  const bool limits_mean = options.max_rms && limits.have_fields;
  const double mean = limits_mean ? *options.max_rms * *options.max_rms : kInfinity;
  // Weights multiply what fusions cost: then no cost says that there is no hope at points.
  const double at_points =
      options.weight.empty() ? squared_limits(tolerances, limits.max_error) : kInfinity;
  limits.max_cost = std::min(kHopeless * at_points + kEdge, mean);
  limits.max_variance = kVarianceOfBound * std::min(at_points, mean);
  return limits;
}

}  // namespace tetfusion
