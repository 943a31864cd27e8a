#include "driver/rounds/round_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/resources.h"
#include "kernel/quadrics/edge_costs.h"

namespace tetfusion {

namespace {

// A bound on costs, on those that weights multiply.
double of_weighted(double bound, const RoundsState& state) {
  return bound * state.weights.scale * state.weights.scale;
}

// When less than this share of the tetrahedra has to go, it may go anywhere; more is spread over
// the mesh.
constexpr double kTrimShare = 1e-4;

// Without a goal, passes over a chunk before the mesh is cut anew.
constexpr int kPassesPerRound = 8;

// A mesh in one piece is worked on until nothing fuses. Where it is cut, some fusions are always
// left on interfaces, a third of them after each round: when a round has removed less than this
// share of the tetrahedra, the run ends. On the way to a goal little may be what was missing; a
// round of tetfuse without one costs as much as another, whatever it removes ...
constexpr double kSaturatedShare = 1e-4;
constexpr double kSaturatedWithoutGoal = 5e-3;
// ... if chunks have at least so many tetrahedra. Smaller ones have so much interface that they are
// doubled first.
constexpr std::uint64_t kSmallChunk = 100'000;
// A round of tetfuse without a goal removes about so much of what the one before did.
constexpr double kNextShare = 0.2;
// Where the last round has left more of the mesh, the next one is thorough.
constexpr double kHardlyLess = 0.9;
// Most take so many: where fusions were refused for the goal's sake and fewer are to go, a further
// round would cut the mesh for one or two, or nothing.
constexpr std::uint64_t kUsualFusion = 6;

double at_round(const std::vector<double>& schedule, std::size_t round, double otherwise) {
  if (schedule.empty()) return otherwise;
  return schedule[std::min(round, schedule.size() - 1)];
}

bool was_rejected(const RoundStatistics& round, Reject reason) {
  return round.pass.rejected[static_cast<std::size_t>(reason)] > 0;
}

// What the squared distance from the surface, as a share of the diagonal, adds to the cost: 1 % of
// the diagonal is as bad as 45 % of a field's range. With more surfaces are nearer still, and
// fields further off (bench/README.md).
constexpr double kSurfaceCost = 2000;

// The largest error at a point in a round, as a share of the root of what its fusions may cost:
// with less errors are smaller, and more attempts are in vain. The larger share is for meshes in
// which a round has refused more vertices for that than it has fused (bench/README.md).
constexpr double kErrorShare = 0.25, kLargerErrorShare = 0.5;

// Where weights are as they are in the mean.
double rising_error(double threshold, const RoundsState& state) {
  const bool refuses_most = std::ranges::any_of(state.rounds, [](const RoundSummary& round) {
    return round.pass.rejected[static_cast<std::size_t>(Reject::kDeviation)] > round.pass.fused;
  });
  return (refuses_most ? kLargerErrorShare : kErrorShare) * std::sqrt(threshold) /
         state.weights.mean;
}

// The first round's threshold is raised by so many times what the gradients' variance costs: with
// less the mesh needs a round more.
constexpr double kVarianceInFirst = 2;

// A first round in which surfaces rest leaves some of the way to the goal to those in which they
// move.
constexpr double kShareAtRest = 0.8;

double diagonal_of(const Box& box) {
  return std::hypot(box.hi.x - box.lo.x, box.hi.y - box.lo.y, box.hi.z - box.lo.z);
}

// A power of two that makes the diagonal a number near 1.
double unit_of(double diagonal) {
  if (!std::isnormal(diagonal)) return 1;
  return std::ldexp(1.0, -std::ilogb(diagonal));
}

// Of regular tetrahedra that would fill the box, squared, in the unit.
double typical_edge_squared(const Box& box, double unit, std::uint64_t tets) {
  const double volume = (box.hi.x - box.lo.x) * unit * ((box.hi.y - box.lo.y) * unit) *
                        ((box.hi.z - box.lo.z) * unit);
  const double edge = std::cbrt(6 * std::numbers::sqrt2 * volume / static_cast<double>(tets));
  return edge * edge;
}

// Of gradients, in the unit, so that it costs about so much across such an edge. A power of two: no
// last bit of a cube root shows in the result.
double gradient_variance(double cost, double edge_squared) {
  const double variance = cost / edge_squared;
  return std::isnormal(variance) ? std::ldexp(1.0, std::ilogb(variance) + 1) : 0;
}

}  // namespace

double flatness(const BehaviourOptions& behaviour, ValueType points) {
  return behaviour.conserve && points == ValueType::kFloat64 ? 0x1p-40 : 0x1p-18;
}

RoundPlan RoundPlanner::plan(const Box& box, std::uint64_t tets,
                             const std::optional<std::uint64_t>& goal,
                             const RoundsState& state) const {
  const std::size_t before = state.rounds.size();
  RoundPlan plan;
  PassLimits& limits = plan.settings.limits;
  limits.boundary_rule = options_.boundary_rule;
  limits.paper.aspect_ratio = options_.aspect_ratio;
  limits.paper.max_volume = options_.max_volume;
  const bool fuse = options_.method == Method::kFuse;
  const double off = std::numeric_limits<double>::infinity();
  limits.paper.scalar_tolerance =
      at_round(options_.scalar_tolerance, before, fuse ? off : kDefaultScalarTolerance);
  limits.paper.stretch_factor =
      at_round(options_.stretch_factor, before, fuse ? off : kDefaultStretchFactor);
  plan.has_goal = goal.has_value();
  if (goal) {
    limits.quota = tets - std::min(tets, *goal);
    // In the first round chunks come in no order.
    const bool much = static_cast<double>(limits.quota) > kTrimShare * static_cast<double>(tets) ||
                      state.rounds.empty();
    limits.spread = state.spread != 0 && much;
  }
  plan.settings.method = options_.method;
  plan.settings.box = box;
  plan.settings.chunk_tets = state.chunk_tets;
  plan.settings.number = static_cast<std::uint32_t>(before + 1);
  plan.settings.shrink = state.shrink;
  // Towards a goal the cut moves on after each pass, so that what lies on an interface gets its
  // turn before the quota is gone.
  plan.settings.passes = !goal && before + 1 >= schedule() ? kPassesPerRound : 1;
  if (fuse) {
    plan_fuse(tets, state, &plan);
    if (goal && plan.settings.fuse.sheets_rest) {
      limits.quota = static_cast<std::uint64_t>(kShareAtRest * static_cast<double>(limits.quota));
    }
  }
  plan.start = wall_seconds();
  return plan;
}

// Where nobody knows yet what fusions cost, the round only looks.
void RoundPlanner::plan_fuse(std::uint64_t tets, const RoundsState& state, RoundPlan* plan) const {
  RoundSettings* const settings = &plan->settings;
  FuseLimits& fuse = settings->fuse;
  settings->is_first = state.rounds.empty();
  settings->look = largest_cost(state.costs) == 0 && settings->is_first;
  const double diagonal = diagonal_of(settings->box);
  fuse.unit = unit_of(diagonal);
  if (options_.boundary != Boundary::kExact) {
    const bool within = options_.boundary == Boundary::kWithin;
    const double width = diagonal * fuse.unit;
    fuse.max_deviation = (within ? options_.boundary_distance : flatness_) * width;
    fuse.sheet_weight = kSurfaceCost / (width * width);
    fuse.feature_angle = options_.feature_angle.value_or(kFeatureAngle);
    if (!state.rounds.empty()) fuse.deviation_before = state.rounds.back().deviation * width;
  }
  fuse.min_quality = options_.min_quality.value_or(kDefaultMinQuality);
  fuse.max_error = errors_.max_error;
  fuse.keep_integrals = options_.conserve;
  fuse.regions = regions_;
  fuse.weights = weights_;
  fuse.weights.scale = state.weights.scale;
  if (settings->look) return;
  fuse.sheets_rest = settings->is_first && fuse.sheets_move();
  const auto to_go = plan->has_goal ? std::optional(settings->limits.quota) : std::nullopt;
  double threshold = next_threshold(state.costs, state.threshold, to_go);
  if (state.threshold.cost == 0) {
    const double edge_squared = typical_edge_squared(settings->box, fuse.unit, tets);
    const double cost =
        cost_of_variance(state.costs, to_go, length_cost(errors_.have_fields) * edge_squared,
                         of_weighted(errors_.max_variance, state));
    fuse.gradient_variance = gradient_variance(cost, edge_squared);
    threshold += kVarianceInFirst * cost;
  }
  fuse.threshold = std::min(threshold, of_weighted(errors_.max_cost, state));
  fuse.thorough = state.threshold.cost > 0 && state.shrink > kHardlyLess;
  if (errors_.rise) fuse.error_now = rising_error(fuse.threshold, state);
}

void RoundPlanner::note(const RoundPlan& plan, const RoundStatistics& round,
                        RoundsState* state) const {
  const double width = diagonal_of(plan.settings.box) * plan.settings.fuse.unit;
  const double deviation = width > 0 ? double{round.deviation} / width : 0;
  const PassLimits& limits = plan.settings.limits;
  state->rounds.push_back({round.pass, limits.paper.scalar_tolerance, limits.paper.stretch_factor,
                           round.chunks, wall_seconds() - plan.start, deviation});
  state->spread = limits.spread ? 1 : 0;
  const std::uint64_t removed = round.pass.removed();
  const bool fuse = options_.method == Method::kFuse;
  state->shrink = 1 - (fuse || plan.has_goal ? 1 : kNextShare) * static_cast<double>(removed) /
                          static_cast<double>(round.pass.tets_before);
  state->costs = round.costs;
  if (plan.settings.look) return;
  if (fuse) {
    state->threshold = {plan.settings.fuse.threshold, was_rejected(round, Reject::kQuota)};
  }
  if (plan.settings.fuse.sheets_rest) return;  // their turn comes
  const bool quota_was_met = state->threshold.quota_was_met;
  const std::uint64_t to_go = limits.quota - removed;
  if (fuse && to_go < (quota_was_met ? kUsualFusion : kSmallestFusion) &&
      (to_go == 0 || removed > 0 || quota_was_met)) {
    state->end = StageEnd::kGoal;
    return;
  }
  const double saturated = plan.has_goal ? kSaturatedShare : kSaturatedWithoutGoal;
  state->end = fuse ? judge_fuse(round, state) : judge(round, saturated, state);
}

StageEnd RoundPlanner::judge(const RoundStatistics& round, double saturated,
                             RoundsState* state) const {
  StageEnd end = StageEnd::kSaturated;
  if (round.pass.fused == 0 && was_rejected(round, Reject::kQuota)) {
    if (state->spread != 0) {
      state->spread = 0;  // the little that is left may go anywhere
      return StageEnd::kOpen;
    }
    end = StageEnd::kGoal;  // every fusion that is allowed would go below it
  } else {
    const auto before = static_cast<double>(round.pass.tets_before);
    const auto removed = static_cast<double>(round.pass.removed());
    const bool next_to_nothing =
        was_rejected(round, Reject::kInterface)
            ? removed <= saturated * before && !was_rejected(round, Reject::kQuota)
            : round.pass.fused == 0;
    if (!next_to_nothing || state->rounds.size() < schedule()) return StageEnd::kOpen;
  }
  if (!was_rejected(round, Reject::kInterface) || state->chunk_tets >= kSmallChunk) return end;
  state->chunk_tets *= 2;
  return StageEnd::kOpen;
}

StageEnd RoundPlanner::judge_fuse(const RoundStatistics& round, RoundsState* state) const {
  const auto before = static_cast<double>(round.pass.tets_before);
  const auto removed = static_cast<double>(round.pass.removed());
  if (state->threshold.quota_was_met) {
    if (removed > 0) return StageEnd::kOpen;
    if (state->spread == 0) return StageEnd::kGoal;
    state->spread = 0;
    return StageEnd::kOpen;
  }
  if (removed > kSaturatedShare * before) return StageEnd::kOpen;
  const bool more_later = errors_.rise && was_rejected(round, Reject::kDeviation) &&
                          rising_error(state->threshold.cost, *state) < errors_.highest;
  const double max_cost = of_weighted(errors_.max_cost, *state);
  const double most = more_later ? max_cost : std::min(max_cost, largest_cost(round.costs));
  return state->threshold.cost >= most ? StageEnd::kSaturated : StageEnd::kOpen;
}

std::size_t RoundPlanner::schedule() const {
  return std::max(options_.scalar_tolerance.size(), options_.stretch_factor.size());
}

}  // namespace tetfusion
