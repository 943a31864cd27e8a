#include "driver/request/stages.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/placeholders.h"

namespace tetfusion {

namespace {

std::uint64_t tets_left(std::uint64_t tets, double reduction) {
  // Rounded up: never below the goal.
  return std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(std::ceil(static_cast<double>(tets) * (1 - reduction) - 1e-6)));
}

}  // namespace

std::vector<Stage> plan_stages(const SimplifyRequest& request, std::uint64_t tets) {
  const BehaviourOptions& b = request.behaviour;
  std::vector<Stage> stages;
  for (const double lod : b.lods) stages.push_back({tets_left(tets, lod), "", ""});
  std::optional<std::uint64_t> goal = b.tets;
  if (b.reduction) goal = tets_left(tets, *b.reduction);
  if (stages.empty() || (goal && *goal < *stages.back().tets)) stages.push_back({goal, "", ""});
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    stages[i].path = with_field(request.output, kLodField, number);
    stages[i].map = with_field(request.map, kLodField, number);
  }
  return stages;
}

void check_levels(const SimplifyRequest& request, std::uint64_t tets) {
  const auto& goal = request.behaviour.tets;
  if (!goal || *plan_stages(request, tets).back().tets >= *goal) return;
  throw Error(ErrorCode::kUsage,
              "--lods goes further than --tets: give one of them, or a goal beyond the last level");
}

}  // namespace tetfusion
