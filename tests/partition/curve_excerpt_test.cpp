#include "partition/curve_excerpt.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.h"

namespace tetfusion {
namespace {

// Keys spread unevenly over the curve.
Vector<std::uint64_t> keys(std::size_t count) {
  Vector<std::uint64_t> keys;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = testing::uniform(3, i);
    keys.push_back(static_cast<std::uint64_t>(x * x * x * 0x1p62));
  }
  return keys;
}

Vector<std::uint64_t> every(const Vector<std::uint64_t>& all, std::size_t step) {
  Vector<std::uint64_t> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

constexpr std::uint64_t kMany = 1'000'000;

// In runs along the curve: how many, and how many points in all.
struct Found {
  std::size_t points = 0, windows = 0;
};

Found look(const CurveExcerpt& excerpt, Vector<std::uint64_t> all) {
  std::sort(all.begin(), all.end());
  Found found;
  bool before = false;
  for (const std::uint64_t key : all) {
    const bool has = excerpt.has(key);
    found.points += has ? 1 : 0;
    found.windows += has && !before ? 1 : 0;
    before = has;
  }
  return found;
}

TEST(CurveExcerpt, IsASixteenthInWindows) {
  const auto all = keys(200'000);
  const Found found = look(CurveExcerpt(all.size(), kMany, every(all, 40)), all);
  EXPECT_EQ(found.windows, 200'000 / (CurveExcerpt::kShare * CurveExcerpt::kWindow));
  EXPECT_LE(found.points, 200'000 / CurveExcerpt::kShare);
  EXPECT_GE(found.points, 200'000 / CurveExcerpt::kShare * 4 / 5);
}

TEST(CurveExcerpt, OfALargeMeshIsNoLarger) {
  const auto all = keys(1'500'000);
  const Found found = look(CurveExcerpt(all.size(), 10'000, every(all, 64)), all);
  EXPECT_EQ(found.windows, 10'000 / CurveExcerpt::kWindow);
  EXPECT_NEAR(static_cast<double>(found.points), 10'000, 1500);
  const Found few = look(CurveExcerpt(all.size(), 1, every(all, 8)), all);
  EXPECT_EQ(few.windows, CurveExcerpt::kLeastWindows);
  EXPECT_NEAR(static_cast<double>(few.points), double{CurveExcerpt::kFew}, 300);
}

TEST(CurveExcerpt, OfASmallMeshIsHalf) {
  const auto all = keys(2'000);
  const Found found = look(CurveExcerpt(all.size(), kMany, all), all);
  EXPECT_EQ(found.windows, CurveExcerpt::kLeastWindows);
  EXPECT_NEAR(static_cast<double>(found.points), 1000, 50);
  const auto few = keys(10);
  EXPECT_LE(look(CurveExcerpt(few.size(), kMany, few), few).points, 10u);
}

TEST(CurveExcerpt, OfPointsInOnePlaceHasThatPlace) {
  const Vector<std::uint64_t> samples(100, 77);
  const CurveExcerpt excerpt(100, kMany, samples);
  EXPECT_TRUE(excerpt.has(77));
  EXPECT_FALSE(excerpt.has(76));
  EXPECT_FALSE(excerpt.has(78));
}

TEST(CurveExcerpt, OfNothingIsNothing) {
  EXPECT_FALSE(CurveExcerpt().has(0));
  EXPECT_FALSE(CurveExcerpt(0, kMany, {}).has(0));
}

}  // namespace
}  // namespace tetfusion
