// How far the steering fields may go from those of the original, with --method fuse.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "driver/request/options.h"
#include "mesh/fusion_log.h"

namespace tetfusion {

struct ErrorLimits {
  bool have_fields = false;  // that steer
  // At any of the original's points, as a share of the range of a field that has no tolerance of
  // its own; infinity is none.
  double max_error = std::numeric_limits<double>::infinity();
  // Of a fusion: the mean of the squares of its deviations.
  double max_cost = std::numeric_limits<double>::infinity();
  // Of the gradients' variance (cost_of_variance()): little beside what bounds allow.
  double max_variance = std::numeric_limits<double>::infinity();
  // Some field has a limit at the original's points: those that go have to be remembered.
  bool at_points = false;
  // Towards a goal these limits rise from round to round.
  bool rise = false;
  // Up to so much: what is allowed to be off by more is allowed anything.
  double highest = 0;
};

// Of each field that steers the bound of its own, a share of its range, if it has one.
using Tolerances = std::vector<std::optional<double>>;
Tolerances tolerances_of(std::span<const SteeringField> fields);

// Of one of the paper's criteria, with a value for each round: is it on in any of them?
bool is_on(const std::vector<double>& values);

// Without a goal and without any limit it is kDefaultMaxError.
ErrorLimits error_limits(const BehaviourOptions& options, const Tolerances& tolerances);

// Is there any limit to what becomes of the fields, with any method?
bool limits_errors(const BehaviourOptions& options, const Tolerances& tolerances);

// What a run's log notes of errors.
FusionErrors noted_errors(const BehaviourOptions& options, const Tolerances& tolerances);

}  // namespace tetfusion
