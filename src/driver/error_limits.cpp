#include "driver/error_limits.h"

#include <algorithm>

namespace tetfusion {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The cost of a fusion is a mean over what the vertex stands for. If its root is above the limit of
// every point there, some point is hopeless.
double cost_of_points(std::span<const SteeringField> fields, double max_error) {
  double squares = 0;
  for (const SteeringField& f : fields) {
    const double limit = f.tolerance.value_or(max_error);
    squares += limit * limit;
  }
  return fields.empty() ? kInfinity : squares;
}

}  // namespace

ErrorLimits error_limits(const BehaviourOptions& options, std::span<const SteeringField> fields) {
  ErrorLimits limits;
  if (options.method != Method::kFuse) return limits;
  const bool own = std::any_of(fields.begin(), fields.end(),
                               [](const SteeringField& f) { return f.tolerance.has_value(); });
  const bool has_goal = options.reduction || options.tets || !options.lods.empty();
  const bool by_default = !has_goal && !options.max_rms && !own;
  limits.max_error = options.max_error.value_or(by_default ? kDefaultMaxError : kInfinity);
  limits.at_points = !fields.empty() && (own || limits.max_error < kInfinity);
  limits.max_cost = cost_of_points(fields, limits.max_error);
  if (options.max_rms) {
    limits.max_cost = std::min(limits.max_cost, *options.max_rms * *options.max_rms);
  }
  return limits;
}

}  // namespace tetfusion
