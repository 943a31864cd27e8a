#include "kernel/criteria.h"

#include <gtest/gtest.h>

namespace tetfusion {
namespace {

using P = Vec3<double>;
constexpr std::array<P, 4> kUnitTet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

TEST(Criteria, CornerFirstKeepsTheSign) {
  const double positive = determinant(kUnitTet[0], kUnitTet[1], kUnitTet[2], kUnitTet[3]).value;
  for (const auto& order : kCornerFirst) {
    EXPECT_EQ(
        determinant(kUnitTet[order[0]], kUnitTet[order[1]], kUnitTet[order[2]], kUnitTet[order[3]])
            .value,
        positive);
  }
}

TEST(Criteria, FlipsBeyondThePlaneAndOnIt) {
  EXPECT_FALSE(flips(P{0, 0, 0}, kUnitTet[1], kUnitTet[2], kUnitTet[3]));
  EXPECT_TRUE(flips(P{1, 1, 1}, kUnitTet[1], kUnitTet[2], kUnitTet[3]));
  EXPECT_TRUE(flips(P{0.5, 0.5, 0}, kUnitTet[1], kUnitTet[2], kUnitTet[3]));
  // One rounding error away from the plane is not certain enough.
  EXPECT_TRUE(flips(P{0.5, 0.5 - 1e-16, 0}, kUnitTet[1], kUnitTet[2], kUnitTet[3]));
  EXPECT_TRUE(flips(P{std::nan(""), 0, 0}, kUnitTet[1], kUnitTet[2], kUnitTet[3]));
}

// Certain as seen from the corner that moves is not certain as seen from one that is far away.
// As `check` sees it: a volume that is too large for a number has no sign.
TEST(Criteria, FlipsWhereAVolumeLeavesTheRange) {
  for (const double scale : {1.0, 1e100, 1e103}) {
    const bool flip = flips(P{0, 0, 0}, P{scale, 0, 0}, P{0, scale, 0}, P{0, 0, scale});
    EXPECT_EQ(flip, scale > 1e102);
  }
}

TEST(Criteria, FlipsAreThoseOfTheCellAsItIsWritten) {
  const Vector<P> points{{1e4, 0, 1e-6}, {0, 1, 0}, {1, 0, 0}, {5, 5, 5}};
  const P x{0, 0, 0};
  const Tet tet{0, 1, 2, 3};
  ASSERT_FALSE(flips(x, points[2], points[1], points[0]));
  EXPECT_TRUE(flips_as_written(x, 3, tet, points));
  EXPECT_FALSE(flips_as_written(x, 3, Tet{1, 2, 0, 3}, points));
  EXPECT_FALSE(flips_as_written(x, 0, Tet{3, 2, 1, 0}, points));
}

TEST(Criteria, StretchIsTheRatioOfBaseNormals) {
  // The corner at the origin moves away from its base triangle, whose centre is (1/3, 1/3, 1/3).
  std::array<P, 4> after = kUnitTet;
  after[0] = {-1.0 / 3, -1.0 / 3, -1.0 / 3};  // twice as far
  EXPECT_FALSE(stretches(kUnitTet, after, 0, 2.001));
  EXPECT_TRUE(stretches(kUnitTet, after, 0, 1.999));
  EXPECT_EQ(base_normal_squared(kUnitTet, 0), 3);  // 144 * (1/12)^2 * 3
}

TEST(Criteria, AspectCountsOnlyWhenItGetsWorse) {
  std::array<P, 4> after = kUnitTet;
  after[3] = {0, 0, 4};
  EXPECT_NEAR(edge_ratio_squared(kUnitTet), 2, 1e-15);
  EXPECT_NEAR(edge_ratio_squared(after), 17, 1e-15);
  EXPECT_TRUE(distorts(kUnitTet, after, 3.0));
  EXPECT_FALSE(distorts(kUnitTet, after, 5.0));
  EXPECT_FALSE(distorts(after, after, 3.0));
}

TEST(Criteria, DeviationOfAVectorIsEuclidean) {
  const std::array<double, 8> values{0, 0, 3, 4, 0, 0, 3, 4};  // two components a vertex
  const std::array<const double*, 4> tuples{&values[0], &values[2], &values[4], &values[6]};
  const std::array<double, 2> mean{1.5, 2};
  const SteeringField field{0, 2, 10.0, {}};
  EXPECT_TRUE(deviates({&field, 1}, 0.25, tuples, mean.data()));  // 2.5 is not below 0.25 * 10
  EXPECT_FALSE(deviates({&field, 1}, 0.2501, tuples, mean.data()));
  const SteeringField own{0, 2, 10.0, 0.1};
  EXPECT_TRUE(deviates({&own, 1}, 0.5, tuples, mean.data()));
}

}  // namespace
}  // namespace tetfusion
