#include "partition/curve_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "mesh/work_mesh.h"
#include "support/cut_meshes.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Vector<Vec3<double>> random_points(std::size_t count, double scale = 1, double offset = 0) {
  Vector<Vec3<double>> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = [&](std::size_t k) { return offset + scale * testing::uniform(9, 3 * i + k); };
    points.push_back({at(0), at(1), at(2)});
  }
  return points;
}

Box box_of(const Vector<Vec3<double>>& points) {
  Box box;
  for (const auto& p : points) box.add(p);
  return box;
}

CurveCut cut_points(const Vector<Vec3<double>>& points, std::uint32_t chunks, std::uint32_t round) {
  const ShiftedCurve curve(box_of(points), round);
  Vector<std::uint64_t> keys;
  for (const auto& p : points) keys.push_back(curve.key(p));
  return CurveCut(curve, chunks, std::move(keys));
}

std::vector<std::size_t> sizes(const CurveCut& cut, const Vector<Vec3<double>>& points) {
  std::vector<std::size_t> out(cut.chunks(), 0);
  for (const auto& p : points) ++out.at(cut.chunk_of(p));
  return out;
}

// One in a hundred may be far away, on each side; what is not has its place.
TEST(Box, WithoutOutliers) {
  Vector<Vec3<double>> points = random_points(1000);
  points.push_back({1e9, 0, -50});
  const Box box = without_outliers<double>(box_of(points), points);
  EXPECT_GT(box.hi.x, 1);
  EXPECT_LT(box.hi.x, 70);
  EXPECT_EQ(box.lo.z, -50);
  EXPECT_LE(box.hi.y, 1);
}

TEST(Box, BoundsFinitePoints) {
  Box box;
  box.add({1, 2, 3});
  box.add({kNan, 0, 0});
  box.add({0, -kInfinity, 0});
  Box other;
  box.add(other);  // empty
  other.add({-1, 5, 3});
  box.add(other);
  EXPECT_EQ(box.lo.x, -1);
  EXPECT_EQ(box.hi.x, 1);
  EXPECT_EQ(box.lo.y, 2);
  EXPECT_EQ(box.hi.y, 5);
  EXPECT_EQ(box.lo.z, 3);
  EXPECT_EQ(box.hi.z, 3);
}

TEST(CurveCut, ChunksHoldAsManySamplesAsTheOthers) {
  const auto points = random_points(10'000);
  for (const std::uint32_t chunks : {1, 2, 3, 16, 100, 1000}) {
    for (const std::uint32_t round : {0, 1, 5}) {
      const CurveCut cut = cut_points(points, chunks, round);
      ASSERT_EQ(cut.chunks(), chunks);
      for (const std::size_t s : sizes(cut, points)) {
        EXPECT_NEAR(double(s), 10'000.0 / chunks, 1);
      }
    }
  }
}

TEST(CurveCut, IsMadeAgainOfWhatItWas) {
  const auto points = random_points(3000);
  for (const std::uint32_t chunks : {1, 2, 40}) {
    const CurveCut cut = cut_points(points, chunks, 3);
    const CurveCut again(cut.curve(), Vector<std::uint64_t>(cut.first_keys()));
    EXPECT_EQ(again.chunks(), chunks);
    for (const auto& p : points) EXPECT_EQ(again.chunk_of(p), cut.chunk_of(p));
  }
}

TEST(CurveCut, ChunksOfAMeshAreBalanced) {
  const auto mesh = testing::to_work_mesh(testing::five_split_cube(20, 0.2, 3));
  for (std::uint32_t round = 0; round < 4; ++round) {
    const CurveCut cut = testing::cut_evenly(mesh, 16, round);
    std::vector<std::size_t> tets(16, 0);
    for (const Tet& t : mesh.tets) {
      const auto chunk = [&](std::size_t k) { return cut.chunk_of(mesh.positions[t[k]]); };
      ++tets.at(std::min({chunk(0), chunk(1), chunk(2), chunk(3)}));
    }
    for (const std::size_t s : tets) {
      EXPECT_GT(s, 2500u / 2);
      EXPECT_LT(s, 2500u * 3 / 2);
    }
  }
}

// A chunk is a piece of the curve, and they are numbered along it.
TEST(CurveCut, ChunksAscendAlongTheCurve) {
  const auto samples = random_points(500);
  auto points = random_points(5000, 1.2, -0.1);  // some lie outside the box
  const ShiftedCurve curve(box_of(samples), 3);
  const CurveCut cut = cut_points(samples, 40, 3);
  std::ranges::sort(points, {}, [&](const auto& p) { return curve.key(p); });
  EXPECT_TRUE(std::ranges::is_sorted(points, {}, [&](const auto& p) { return cut.chunk_of(p); }));
  EXPECT_EQ(cut.chunk_of(points.front()), 0u);
  EXPECT_EQ(cut.chunk_of(points.back()), 39u);
}

// Of several equal keys all go to one side; and a cut lies where its sample does, whatever table
// finds it: many cuts fall into the same short piece of the curve here.
TEST(CurveCut, FindsCutsThatLieCloseTogether) {
  auto points = random_points(3000, 1e-4);
  points.push_back({1, 1, 1});
  points.push_back({-1, -1, -1});
  const CurveCut cut = cut_points(points, 300, 2);
  const std::vector<std::size_t> counts = sizes(cut, points);
  EXPECT_LE(*std::ranges::max_element(counts), 13u);
}

TEST(CurveCut, IsAFunctionOfThePoint) {
  const auto points = random_points(2000);
  auto shuffled = points;
  std::ranges::reverse(shuffled);
  const CurveCut a = cut_points(points, 30, 1), b = cut_points(shuffled, 30, 1);
  for (const auto& p : points) EXPECT_EQ(a.chunk_of(p), b.chunk_of(p));
}

TEST(CurveCut, EachRoundCutsElsewhere) {
  const auto points = random_points(4000);
  std::set<std::vector<std::uint32_t>> cuts;
  for (std::uint32_t round = 0; round < 8; ++round) {
    const CurveCut cut = cut_points(points, 8, round);
    std::vector<std::uint32_t> chunks;
    for (const auto& p : points) chunks.push_back(cut.chunk_of(p));
    cuts.insert(chunks);
  }
  EXPECT_EQ(cuts.size(), 8u);
}

TEST(CurveCut, DefaultsToOneChunk) {
  EXPECT_EQ(CurveCut().chunks(), 1u);
  EXPECT_EQ(CurveCut().chunk_of(Vec3<float>{1, 2, 3}), 0u);
  const CurveCut no_samples(ShiftedCurve(Box(), 1), 5, {});
  EXPECT_EQ(no_samples.chunks(), 1u);
  EXPECT_EQ(no_samples.chunk_of(Vec3<float>{1, 2, 3}), 0u);
}

TEST(CurveCut, TakesPointsThatAreAllInOnePlace) {
  const Vector<Vec3<double>> points(100, Vec3<double>{4, 4, 4});
  const CurveCut cut = cut_points(points, 7, 1);
  const std::vector<std::size_t> counts = sizes(cut, points);
  EXPECT_EQ(std::ranges::count(counts, 100u), 1);
  EXPECT_EQ(std::ranges::count(counts, 0u), static_cast<std::ptrdiff_t>(counts.size()) - 1);
}

TEST(CurveCut, TakesFewerSamplesThanChunks) {
  const auto points = random_points(3);
  const CurveCut cut = cut_points(points, 10, 1);
  std::size_t all = 0;
  for (const std::size_t s : sizes(cut, points)) all += s;
  EXPECT_EQ(all, 3u);
}

TEST(CurveCut, TakesTheWholeRangeOfDoubles) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  Vector<Vec3<double>> points = random_points(100, kHuge);
  points.push_back({-kHuge, -kHuge, -kHuge});
  const CurveCut cut = cut_points(points, 4, 2);
  const std::vector<std::size_t> counts = sizes(cut, points);
  EXPECT_GT(std::ranges::count_if(counts, [](std::size_t s) { return s > 0; }), 1);
  for (const double odd : {kNan, kInfinity, -kInfinity}) {
    EXPECT_LT(cut.chunk_of(Vec3<double>{odd, odd, odd}), 4u);
  }
  const auto tiny = random_points(100, std::numeric_limits<double>::denorm_min() * 1e6);
  EXPECT_LT(cut_points(tiny, 4, 1).chunk_of(tiny[50]), 4u);
}

}  // namespace
}  // namespace tetfusion
