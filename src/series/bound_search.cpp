#include "series/bound_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "base/error.h"

namespace tetfusion {

namespace {

// Sums of steps, where there is a goal and where a bound alone says how far to go (README.md).
constexpr std::size_t kFewSums = 6, kManySums = 8;

// How much of the bound the sums may use, as what is off by that much there may be off by more in a
// step; and what becomes of that share where it turns out to have been too much (README.md).
constexpr double kFirstShare = 0.95, kLess = 0.8, kMuchLess = 0.5;
constexpr int kLessTries = 5, kMostTries = 12;
// Steps that are off by more than they may become fields by themselves first: the worst of them,
// and how many in all.
constexpr std::size_t kWorst = 4, kMostAlone = 12;
// A bound that no step has come near to was held too strictly: sums of steps that are alike are
// larger than these. What is to become of it, and how often that is worth another try.
constexpr double kNear = 0.6, kAim = 0.85, kMostAtOnce = 8;
constexpr int kMoreTries = 2;

}  // namespace

BoundSearch::BoundSearch(bool has_goal, std::size_t steps) : steps_(steps), share_(kFirstShare) {
  sums_.sums = has_goal ? kFewSums : kManySums;
}

BoundSearch::Next BoundSearch::after(int tries, const std::vector<Worst>& steps,
                                     bool goal_was_reached, const RunContext& context) {
  const auto worst = std::ranges::max_element(steps, {}, &Worst::used);
  const double used = worst == steps.end() ? 0 : worst->used;
  if (used > 1) return tighten(tries, steps, *worst, context);
  const bool was_too_little = used > 0 && used < kNear;
  if (!was_too_little || was_too_much_ || goal_was_reached || loosened_ == kMoreTries) {
    return Next::kDone;
  }
  ++loosened_;
  context.say(
      fmt::format("no step is off by more than {:.3g} times the bound: once more, with a looser "
                  "one for the sums of steps",
                  used));
  share_ *= std::min(kAim / used, kMostAtOnce);
  return Next::kAgain;
}

BoundSearch::Next BoundSearch::tighten(int tries, const std::vector<Worst>& steps,
                                       const Worst& worst, const RunContext& context) {
  if (tries >= kMostTries) {
    throw Error(ErrorCode::kBroken,
                fmt::format("the bound on the error could not be kept at all steps: {}; nothing "
                            "was written. Give a larger --max-error, or --series each",
                            worst.what));
  }
  const bool few = sums_.sums < std::min(kManySums, steps_);
  const bool alone = !few && add_alone(steps);
  context.say(fmt::format("{}: once more, with {}", worst.what,
                          few     ? "more sums of steps"
                          : alone ? "a bound for the worst steps themselves"
                                  : "a tighter bound for the sums of steps"));
  // Where steps cancel in their sums a tighter bound does not help for ever.
  const bool others = few || alone || was_too_much_;
  if (few) {
    sums_.sums = kManySums;
    share_ = kFirstShare;
    return Next::kOtherSums;
  }
  if (!alone) {
    if (was_too_much_) sums_.way = static_cast<std::uint64_t>(tries);
    share_ *= tries <= kLessTries ? kLess : kMuchLess;
  }
  was_too_much_ = true;
  return others ? Next::kOtherSums : Next::kAgain;
}

// Of those beyond their bounds the worst that are in sums alone. False if there is none, or no
// room.
bool BoundSearch::add_alone(const std::vector<Worst>& steps) {
  if (sums_.sums >= steps_) return false;  // each is one
  std::vector<std::size_t>& alone = sums_.alone;
  std::vector<std::size_t> beyond;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].used > 1 && std::ranges::find(alone, i) == alone.end()) beyond.push_back(i);
  }
  std::ranges::stable_sort(beyond, std::greater{}, [&](std::size_t i) { return steps[i].used; });
  beyond.resize(std::min({beyond.size(), kWorst, kMostAlone - alone.size()}));
  alone.insert(alone.end(), beyond.begin(), beyond.end());
  return !beyond.empty();
}

}  // namespace tetfusion
