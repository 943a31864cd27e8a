// Parts of two meshes: what hangs together, and which of them are the same.
#include "compare/parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::uniform;

PartFigures box(const Point& low, const Point& high) {
  PartFigures part;
  part.add({low, {high.x, low.y, low.z}, {low.x, high.y, low.z}, {low.x, low.y, high.z}});
  part.box.add(high);
  return part;
}

TEST(Parts, AreWhatTetrahedraJoin) {
  PartFinder finder(12);
  finder.add(std::vector<Tet>{{8, 9, 10, 11}, {2, 3, 4, 5}});
  finder.add(std::vector<Tet>{{5, 6, 1, 2}});
  std::uint32_t count = 0;
  EXPECT_THAT(finder.parts([](std::size_t p) { return p != 0 && p != 7; }, &count),
              ElementsAre(kAnyPart, 0, 0, 0, 0, 0, 0, kAnyPart, 1, 1, 1, 1));
  EXPECT_EQ(count, 2u);
}

TEST(Parts, AreFoundAgain) {
  std::vector<PartFigures> from, to;
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Point at{10 * uniform(1, i), 10 * uniform(2, i), 10 * uniform(3, i)};
    const double size = 0.1 + uniform(4, i), moved = 1e-3 * uniform(5, i);
    from.push_back(box(at, at + Point{size, size, 2 * size}));
    to.push_back(box(at + Point{moved, 0, moved}, at + Point{size, size + moved, 2 * size}));
  }
  std::reverse(to.begin(), to.end());
  const Vector<std::uint32_t> match = find_counterparts(from, to);
  ASSERT_EQ(match.size(), 500u);
  for (std::uint32_t i = 0; i < 500; ++i) EXPECT_EQ(match[i], 499 - i);
}

TEST(Parts, InAnyUnit) {
  for (const double unit : {1e-300, 1e-60, 1.0, 1e60, 1e300}) {
    const std::vector<PartFigures> from{box({0, 0, 0}, {unit, unit, unit}),
                                        box({unit, 0, 0}, {2 * unit, unit, unit})};
    EXPECT_THAT(find_counterparts(from, std::vector{from[1], from[0]}), ElementsAre(1, 0));
  }
}

TEST(Parts, ThatCannotBeToldApartAreAnyPart) {
  const PartFigures one = box({0, 0, 0}, {1, 1, 1}), other = box({5, 0, 0}, {6, 1, 1});
  EXPECT_THAT(find_counterparts(std::vector{one, one, other}, std::vector{one, one, other}),
              ElementsAre(kAnyPart, kAnyPart, 2));
  EXPECT_THAT(find_counterparts(std::vector{one, other}, std::vector{one, one, other}), IsEmpty());
  EXPECT_THAT(find_counterparts(std::vector{one}, std::vector{one}), IsEmpty());
}

// Two boxes of different sizes in one place, and an inclusion in another one.
TEST(Parts, InOnePlaceAreToldApartBySize) {
  const std::vector<PartFigures> from{box({0, 0, 0}, {4, 4, 4}), box({1, 1, 1}, {2, 2, 2}),
                                      box({0, 0, 0}, {3.9, 4, 4})};
  EXPECT_THAT(find_counterparts(from, from), ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace tetfusion
