#include "series/bound_search.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace tetfusion {

namespace {

// Sums of steps, where there is a goal and where a bound alone says how far to go (README.md).
constexpr std::size_t kFewSums = 6, kManySums = 8;

// How much of the bound the sums may use, as what is off by that much there may be off by more in a
// step; and what becomes of that share where it turns out to have been too much (README.md).
constexpr double kFirstShare = 0.95, kLess = 0.8, kMuchLess = 0.5;
constexpr int kLessTries = 5, kMostTries = 12;
// A bound that no step has come near to was held too strictly: sums of steps that are alike are
// larger than these. What is to become of it, and how often that is worth another try.
constexpr double kNear = 0.6, kAim = 0.85, kMostAtOnce = 8;
constexpr int kMoreTries = 2;

}  // namespace

BoundSearch::BoundSearch(bool has_goal, std::size_t steps) : steps_(steps), share_(kFirstShare) {
  sums_.sums = has_goal ? kFewSums : kManySums;
}

BoundSearch::Next BoundSearch::after(int tries, const Worst& worst, bool goal_was_reached,
                                     const RunContext& context) {
  const double used = worst.used;
  if (used > 1) return tighten(tries, worst, context);
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

BoundSearch::Next BoundSearch::tighten(int tries, const Worst& worst, const RunContext& context) {
  if (tries >= kMostTries) {
    throw Error(ErrorCode::kBroken,
                fmt::format("the bound on the error could not be kept at all steps: {}; nothing "
                            "was written. Give a larger --max-error, or --series each",
                            worst.what));
  }
  const bool few = sums_.sums < std::min(kManySums, steps_);
  context.say(fmt::format("{}: once more, with {} sums of steps", worst.what,
                          few ? "more" : "a tighter bound for the"));
  // Where steps cancel in their sums a tighter bound does not help for ever.
  const bool others = few || was_too_much_;
  if (others) sums_ = {kManySums, few ? 0 : static_cast<std::uint64_t>(tries)};
  share_ = few ? kFirstShare : share_ * (tries <= kLessTries ? kLess : kMuchLess);
  was_too_much_ = !few;
  return others ? Next::kOtherSums : Next::kAgain;
}

}  // namespace tetfusion
