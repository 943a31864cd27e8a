#include "base/progress.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetfusion {
namespace {

TEST(ProgressEstimate, NeverFalls) {
  ProgressEstimate progress(0);
  progress.update(0.5, 1);
  progress.update(0.3, 2);
  EXPECT_EQ(progress.share(), 0.5);
  progress.update(7, 3);
  EXPECT_EQ(progress.share(), 1);
  ProgressEstimate odd(0);
  odd.update(-1, 1);
  odd.update(std::nan(""), 2);
  EXPECT_EQ(odd.share(), 0);
}

TEST(ProgressEstimate, SaysNothingTooEarlyNorAtTheEnd) {
  ProgressEstimate progress(100);
  progress.update(0, 100);
  EXPECT_FALSE(progress.seconds_left(105)) << "nothing is done";
  progress.update(0.01, 105);
  EXPECT_FALSE(progress.seconds_left(105));
  EXPECT_FALSE(progress.rate(1000, 105));
  progress.update(0.02, 106);
  EXPECT_TRUE(progress.seconds_left(106));
  EXPECT_TRUE(progress.rate(1000, 106));
  ProgressEstimate quick(100);
  quick.update(0, 100);
  quick.update(0.5, 101);
  EXPECT_FALSE(quick.seconds_left(101.9)) << "two seconds are not over";
  EXPECT_TRUE(quick.seconds_left(102));
  quick.update(1, 103);
  EXPECT_FALSE(quick.seconds_left(103));
}

TEST(ProgressEstimate, IsExactAtASteadyPace) {
  ProgressEstimate progress(0);
  progress.update(0, 10);  // the clock runs from the first report
  for (int second = 1; second < 100; ++second) {
    progress.update(second / 100.0, 10 + second);
    const auto left = progress.seconds_left(10 + second);
    if (second < 2) continue;
    ASSERT_TRUE(left);
    EXPECT_NEAR(*left, 100 - second, 1e-9);
    EXPECT_NEAR(*progress.rate(5000, 10 + second), 50, 1e-9);
  }
}

TEST(ProgressEstimate, CountsOnlyWhatThisRunDid) {
  ProgressEstimate progress(0);
  progress.update(0.6, 0);
  EXPECT_FALSE(progress.seconds_left(10));
  progress.update(0.7, 10);
  EXPECT_NEAR(*progress.seconds_left(10), 30, 1e-9);
  EXPECT_NEAR(*progress.rate(1000, 10), 10, 1e-9);
}

TEST(ProgressEstimate, TheEndDoesNotJump) {
  ProgressEstimate progress(0);
  progress.update(0, 0);
  progress.update(0.1, 10);
  EXPECT_NEAR(*progress.seconds_left(10), 90, 1e-9);
  progress.update(0.5, 10.1);
  const double soon = *progress.seconds_left(10.1);
  EXPECT_LT(soon, 89.9);
  EXPECT_GT(soon, 80);
  double left = soon;
  for (double now = 10.2; now < 15; now += 0.1) left = *progress.seconds_left(now);
  EXPECT_LT(left, 40) << "it does follow";
  // While nothing is done the end moves away, so a run that hangs does not promise to be ready.
  for (double now = 15; now < 60; now += 0.1) left = *progress.seconds_left(now);
  EXPECT_GT(left, 45);
}

}  // namespace
}  // namespace tetfusion
