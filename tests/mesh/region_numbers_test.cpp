#include "mesh/regions/region_numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <vector>

namespace tetfusion {
namespace {

using ::testing::ElementsAre;

template <class T>
Vector<std::uint64_t> keys_of(std::vector<T> values) {
  return region_keys(value_type_of<T>(), std::as_bytes(std::span(values)));
}

TEST(RegionNumbers, KeysAreEqualWhereValuesMeanTheSame) {
  EXPECT_THAT(keys_of<std::int8_t>({-1, 0, 127}), ElementsAre(255u, 0u, 127u));
  EXPECT_THAT(keys_of<std::uint64_t>({~std::uint64_t{0}}), ElementsAre(~std::uint64_t{0}));
}

template <class T>
void expect_keys_of_floats() {
  using Limits = std::numeric_limits<T>;
  const T nan = Limits::quiet_NaN();
  const auto keys =
      keys_of<T>({T{0}, -T{0}, nan, -nan, std::copysign(Limits::signaling_NaN(), T{-1}), T{1},
                  std::nextafter(T{1}, T{2}), T{-1}, Limits::denorm_min(), -Limits::denorm_min(),
                  Limits::infinity(), -Limits::infinity()});
  EXPECT_EQ(keys[0], keys[1]);
  EXPECT_EQ(keys[2], keys[3]);
  EXPECT_EQ(keys[2], keys[4]);
  const std::set<std::uint64_t> different(keys.begin(), keys.end());
  EXPECT_EQ(different.size(), keys.size() - 3);
}

TEST(RegionNumbers, KeysOfFloatsAreThoseOfTheirBits) {
  expect_keys_of_floats<float>();
  expect_keys_of_floats<double>();
}

TEST(RegionNumbers, ComeInOrder) {
  RegionNumbers numbers;
  EXPECT_EQ(numbers.number(0, 70), 0u);
  EXPECT_EQ(numbers.number(0, 30), 1u);
  EXPECT_EQ(numbers.number(1, 70), 2u);
  EXPECT_EQ(numbers.number(0, 70), 0u);
  EXPECT_EQ(numbers.size(), 3u);
}

// As many as a mesh may have cells with values of their own.
TEST(RegionNumbers, MayBeMany) {
  RegionNumbers numbers;
  constexpr std::uint32_t kMany = 100'000;
  for (int round = 0; round < 2; ++round) {
    for (std::uint32_t i = 0; i < kMany; ++i) {
      ASSERT_EQ(numbers.number(i % 3, std::uint64_t{i} << 32), i);
    }
  }
  EXPECT_EQ(numbers.size(), kMany);
}

}  // namespace
}  // namespace tetfusion
