#include "mesh/predicates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using P = Vec3<double>;

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr P kOrigin{0, 0, 0};

TEST(Predicates, SignOfASimpleCell) {
  const P x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  EXPECT_EQ(determinant(kOrigin, x, y, z).sign(), 1);
  EXPECT_EQ(determinant(kOrigin, y, x, z).sign(), -1);
  EXPECT_EQ(determinant(kOrigin, x, y, P{1, 1, 0}).sign(), 0);
  EXPECT_EQ(determinant(kOrigin, x, y, z).value, 1);
}

TEST(Predicates, OverflowIsUncertain) {
  // u.y * v.z overflows, and the bound does not. The true value is negative.
  const P u{1e154, 1.5e154, 1.3e154}, v{0, 1.3e154, 1.5e154}, w{1e-10, 1e-9, 0};
  EXPECT_EQ(determinant(kOrigin, u, v, w).sign(), 0);
  const P huge{kLargest, 0, 0}, far{-kLargest, 0, 0};
  EXPECT_EQ(determinant(far, huge, P{0, 1, 0}, P{0, 0, 1}).sign(), 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const P& p : {P{nan, 0, 1}, P{0, nan, 1}, P{0, 0, nan}}) {
    EXPECT_EQ(determinant(kOrigin, P{1, 0, 0}, P{0, 1, 0}, p).sign(), 0);
  }
}

// A sign that is called certain is right, whatever the lengths of the edges. Long doubles have the
// range for that; where they have not the precision nothing is claimed here.
TEST(PredicatesProperty, ACertainSignIsRight) {
  const double scales[] = {1, 1e-165, 1e160, 1e-107, 1e-110, 1e-300, 1e-320, 1e100, 1e150};
  std::uint64_t next = 0, certain = 0;
  const auto random = [&] { return 2 * testing::uniform(1, ++next) - 1; };
  for (const double su : scales) {
    for (const double sv : scales) {
      for (const double sw : scales) {
        for (int round = 0; round < 300; ++round) {
          P u{random(), random(), random()}, v{random(), random(), random()};
          if (round % 2 == 0) v = {u.x + 1e-3 * v.x, u.y + 1e-3 * v.y, u.z + 1e-3 * v.z};
          u = {u.x * su, u.y * su, u.z * su};
          v = {v.x * sv, v.y * sv, v.z * sv};
          const P w{random() * sw, random() * sw, random() * sw};
          const int sign = determinant(kOrigin, u, v, w).sign();
          if (sign == 0) continue;
          using L = long double;
          const L value = w.x * (L{u.y} * v.z - L{u.z} * v.y) +
                          w.y * (L{u.z} * v.x - L{u.x} * v.z) + w.z * (L{u.x} * v.y - L{u.y} * v.x);
          const auto size = [](const P& p) {
            return L{std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)})};
          };
          if (std::abs(value) < 1e-17L * size(u) * size(v) * size(w)) continue;
          ++certain;
          ASSERT_EQ(sign, value > 0 ? 1 : -1) << su << ' ' << sv << ' ' << sw;
        }
      }
    }
  }
  EXPECT_GT(certain, 10000u);
}

}  // namespace
}  // namespace tetfusion
