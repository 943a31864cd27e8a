#include "mesh/tet_overlap.h"

#include <gtest/gtest.h>

#include <utility>

#include "mesh/predicates.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

double overlap(const TetCorners& a, const TetCorners& b) {
  return OverlapTet(a).with(b).volume;
}

double volume(const TetCorners& t) { return determinant(t[0], t[1], t[2], t[3]).value; }

TetCorners random_tet(std::uint64_t seed) {
  TetCorners t{};
  for (std::uint64_t i = 0; i < 4; ++i) {
    t[i] = {testing::uniform(seed, 3 * i), testing::uniform(seed, 3 * i + 1),
            testing::uniform(seed, 3 * i + 2)};
  }
  if (volume(t) < 0) std::swap(t[0], t[1]);
  return t;
}

TetCorners moved(TetCorners t, double by) {
  for (auto& p : t) p.x += by;
  return t;
}

const TetCorners kUnitTet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

TEST(TetOverlap, OfATetrahedronWithItselfAndWithNeighbours) {
  EXPECT_DOUBLE_EQ(overlap(kUnitTet, kUnitTet), 1);
  EXPECT_EQ(overlap(kUnitTet, moved(kUnitTet, 1)), 0);
  EXPECT_EQ(overlap(kUnitTet, moved(kUnitTet, 5)), 0);
  const TetCorners below{{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}}};
  EXPECT_EQ(overlap(kUnitTet, below), 0);  // they share a face
}

// Pushed along an edge by half of it, what is in both is a tetrahedron of half the size.
TEST(TetOverlap, OfOneThatIsPushed) {
  EXPECT_DOUBLE_EQ(overlap(kUnitTet, moved(kUnitTet, 0.5)), 0.125);
  TetCorners small = kUnitTet;
  for (auto& p : small) p = {0.1 + p.x / 4, 0.1 + p.y / 4, 0.1 + p.z / 4};
  EXPECT_DOUBLE_EQ(overlap(kUnitTet, small), volume(small));
  EXPECT_DOUBLE_EQ(overlap(small, kUnitTet), volume(small));
}

// Cut into four at a point inside, the parts' overlaps with any other add up; and either may come
// first.
TEST(TetOverlap, IsTheSameFarAway) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    TetCorners a = random_tet(seed), b = random_tet(seed + 1000);
    const auto for_all = [&](auto change) {
      for (TetCorners* tet : {&a, &b}) {
        for (Vec3<double>& p : *tet) p = {change(p.x), change(p.y), change(p.z)};
      }
    };
    for_all([](double c) { return std::round(c * 0x1p20) * 0x1p-20; });
    const double near = overlap(a, b);
    for_all([](double c) { return c + 0x1p24; });
    EXPECT_EQ(overlap(a, b), near);
  }
}

TEST(TetOverlap, AddsUp) {
  double largest = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const TetCorners a = random_tet(seed), b = random_tet(seed + 1000);
    const double all = overlap(a, b);
    EXPECT_NEAR(overlap(b, a), all, 1e-14);
    EXPECT_LE(all, std::min(volume(a), volume(b)) + 1e-14);
    const Vec3<double> inside{0.1 * a[0].x + 0.2 * a[1].x + 0.3 * a[2].x + 0.4 * a[3].x,
                              0.1 * a[0].y + 0.2 * a[1].y + 0.3 * a[2].y + 0.4 * a[3].y,
                              0.1 * a[0].z + 0.2 * a[1].z + 0.3 * a[2].z + 0.4 * a[3].z};
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      TetCorners part = a;
      part[i] = inside;
      sum += overlap(part, b);
    }
    EXPECT_NEAR(sum, all, 1e-14);
    largest = std::max(largest, all);
  }
  EXPECT_GT(largest, 0.03);
}

}  // namespace
}  // namespace tetfusion
