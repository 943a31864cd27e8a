// What each round is to do, and whether it was the last one of its stage.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "driver/arrays/weights.h"
#include "driver/request/error_limits.h"
#include "driver/request/options.h"
#include "driver/request/report.h"
#include "driver/rounds/rounds.h"
#include "driver/rounds/thresholds.h"

namespace tetfusion {

// How the stage in hand has ended.
enum class StageEnd : std::uint8_t {
  kOpen,       // not yet
  kGoal,       // as near to its goal as can be
  kSaturated,  // nothing fuses any more
};

// What the rounds so far have left for the next one, besides the mesh.
struct RoundsState {
  std::vector<RoundSummary> rounds;  // so far
  std::uint64_t chunk_tets = 0;      // of the next round
  double shrink = 1;                 // what the last round has left of the mesh
  std::uint8_t spread = 1;           // what has to go is spread over the mesh
  CostHistogram costs{};             // with Method::kFuse
  Threshold threshold;               // of the last round
  WeightScale weights;
  StageEnd end = StageEnd::kOpen;

  void begin_stage() {
    end = StageEnd::kOpen;
    spread = 1;
  }
};

struct RoundPlan {
  RoundSettings settings;
  bool has_goal = false;
  double start = 0;  // wall_seconds()
};

// With a planar boundary flat is what is flat but for the rounding of coordinates, by at most this
// share of the diagonal: a point of a slanted plane is up to 2^-24 of the mesh off it in single
// precision, or with seven digits in a text, and such errors add up where many vertices become one,
// so 64 times that; but 2^-40 where integrals stay and the points are in double precision, as a
// domain that changes by more takes its integrals with it.
double flatness(const BehaviourOptions& behaviour, ValueType points);

class RoundPlanner {
 public:
  // The type of the points; columns of chunks: the regions, and the weights. The options outlive
  // this.
  RoundPlanner(const BehaviourOptions& behaviour, ValueType points,
               std::vector<std::uint32_t> regions, const WeightColumn& weights)
      : options_(behaviour),
        flatness_(flatness(behaviour, points)),
        regions_(std::move(regions)),
        weights_(weights) {}

  // To be called before the first round.
  void limit_errors(const ErrorLimits& limits) { errors_ = limits; }

  // The round after those in the state, over a mesh of so many tetrahedra; `box` is the input's. A
  // function of its arguments, but for the time.
  RoundPlan plan(const Box& box, std::uint64_t tets, const std::optional<std::uint64_t>& goal,
                 const RoundsState& state) const;

  // Notes what the round did.
  void note(const RoundPlan& plan, const RoundStatistics& round, RoundsState* state) const;

 private:
  void plan_fuse(std::uint64_t tets, const RoundsState& state, RoundPlan* plan) const;
  StageEnd judge(const RoundStatistics& round, double saturated, RoundsState* state) const;
  StageEnd judge_fuse(const RoundStatistics& round, RoundsState* state) const;
  std::size_t schedule() const;

  const BehaviourOptions& options_;
  const double flatness_;
  const std::vector<std::uint32_t> regions_;
  const WeightColumn weights_;
  ErrorLimits errors_;
};

}  // namespace tetfusion
