#include "series/bound_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"

namespace tetfusion {
namespace {

using Next = BoundSearch::Next;

TEST(BoundSearch, IsDoneWhereAStepComesNearToItsBound) {
  BoundSearch search(false, 30);
  EXPECT_EQ(search.sums().sums, 8U);
  EXPECT_DOUBLE_EQ(search.share(), 0.95);
  EXPECT_EQ(search.after(1, {{0.7, "it is off"}}, false, {}), Next::kDone);
  EXPECT_EQ(search.after(1, {{1, "it is off"}}, false, {}), Next::kDone);
  EXPECT_EQ(search.after(1, {{0, "it is off"}}, false, {}), Next::kDone);  // nothing is bounded
}

TEST(BoundSearch, FewSumsThatBreakTheBoundBecomeMany) {
  BoundSearch search(true, 30);
  EXPECT_EQ(search.sums().sums, 6U);
  EXPECT_EQ(search.after(1, {{1.1, "it is off"}}, false, {}), Next::kOtherSums);
  EXPECT_EQ(search.sums().sums, 8U);
  EXPECT_EQ(search.sums().way, 0U);
  EXPECT_DOUBLE_EQ(search.share(), 0.95);
}

TEST(BoundSearch, TheWorstStepsBecomeFieldsThemselves) {
  BoundSearch search(false, 30);
  std::vector<BoundSearch::Worst> steps(30, {0.5});
  for (const std::size_t i : {3, 5, 7, 11, 13}) steps[i] = {1 + 0.01 * static_cast<double>(i)};
  EXPECT_EQ(search.after(1, steps, false, {}), Next::kOtherSums);
  EXPECT_THAT(search.sums().alone, ::testing::ElementsAre(13, 11, 7, 5));
  EXPECT_EQ(search.sums().way, 0U);
  EXPECT_DOUBLE_EQ(search.share(), 0.95);
  EXPECT_EQ(search.after(2, steps, false, {}), Next::kOtherSums);
  EXPECT_THAT(search.sums().alone, ::testing::ElementsAre(13, 11, 7, 5, 3));
  EXPECT_EQ(search.after(3, steps, false, {}), Next::kOtherSums);  // all are
  EXPECT_DOUBLE_EQ(search.share(), 0.95 * 0.8);
  // Few are.
  BoundSearch other(false, 30);
  for (int tries = 1; tries < 6; ++tries) other.after(tries, {30, {1.5}}, false, {});
  EXPECT_EQ(other.sums().alone.size(), 12U);
}

TEST(BoundSearch, TightensAndFromTheSecondTimeAddsUpInAnotherWay) {
  BoundSearch search(false, 30);
  search.after(1, {{1.1, "it is off"}}, false, {});
  EXPECT_THAT(search.sums().alone, ::testing::ElementsAre(0));
  EXPECT_EQ(search.after(2, {{1.1, "it is off"}}, false, {}), Next::kOtherSums);
  EXPECT_DOUBLE_EQ(search.share(), 0.95 * 0.8);
  EXPECT_EQ(search.sums().way, 2U);
  EXPECT_THAT(search.sums().alone, ::testing::ElementsAre(0));
  // What was too much once is not loosened again.
  EXPECT_EQ(search.after(3, {{0.1, "it is off"}}, false, {}), Next::kDone);
}

// Sums of single steps are the steps themselves.
TEST(BoundSearch, HasNoMoreSumsThanSteps) {
  BoundSearch search(true, 3);
  EXPECT_EQ(search.after(1, {{1.1, "it is off"}}, false, {}), Next::kAgain);
}

TEST(BoundSearch, LoosensTwiceUnlessTheGoalIsReached) {
  BoundSearch search(false, 30);
  EXPECT_EQ(search.after(1, {{0.5, "it is off"}}, true, {}), Next::kDone);
  EXPECT_EQ(search.after(1, {{0.5, "it is off"}}, false, {}), Next::kAgain);
  EXPECT_DOUBLE_EQ(search.share(), 0.95 * (0.85 / 0.5));
  EXPECT_EQ(search.after(2, {{0.001, "it is off"}}, false, {}), Next::kAgain);
  EXPECT_DOUBLE_EQ(search.share(), 0.95 * (0.85 / 0.5) * 8);  // at most
  EXPECT_EQ(search.after(3, {{0.5, "it is off"}}, false, {}), Next::kDone);
}

TEST(BoundSearch, GivesUpAfterTwelve) {
  BoundSearch search(false, 30);
  std::vector<std::string> said;
  RunContext context;
  context.notice = [&](std::string_view text) { said.emplace_back(text); };
  for (int tries = 1; tries < 12; ++tries)
    search.after(tries, {{1.5, "it is off"}}, false, context);
  EXPECT_EQ(said.size(), 11U);
  EXPECT_EQ(said[0], "it is off: once more, with a bound for the worst steps themselves");
  EXPECT_EQ(said[1], "it is off: once more, with a tighter bound for the sums of steps");
  try {
    search.after(12, {{1.5, "it is off"}}, false, context);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBroken);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("at all steps: it is off; nothing was written"));
  }
}

}  // namespace
}  // namespace tetfusion
