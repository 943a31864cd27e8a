#include "io/source/piece_numbers.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "io/source/merge_pieces.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::uniform;

// Points on a small lattice, so that many coincide, within pieces too.
struct RandomPieces {
  Vector<Vec3<double>> points;
  std::vector<std::uint64_t> begins{0};
  Vector<std::uint8_t> used;

  RandomPieces(std::uint64_t seed, std::size_t pieces) {
    for (std::size_t p = 0; p < pieces; ++p) {
      const auto count = static_cast<std::uint64_t>(uniform(seed, p) * 400);
      for (std::uint64_t i = 0; i < count; ++i) {
        const auto pick = [&](std::uint64_t k) {
          return static_cast<double>(
              static_cast<int>(uniform(seed + 9, 3 * points.size() + k) * 9) - 4);
        };
        points.push_back({pick(0) * 0.0 - pick(0), pick(1), pick(2)});
        used.push_back(uniform(seed + 5, points.size()) < 0.8 ? 1 : 0);
      }
      begins.push_back(points.size());
    }
  }
};

TEST(PieceNumbers, AreThoseOfAMeshReadWhole) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const RandomPieces mesh(seed, 1 + seed % 5);
    const std::uint64_t all = mesh.points.size();
    const Points points = mesh.points;
    Geometry geometry;
    geometry.points = points;
    const auto copy_of = match_points({&points, mesh.begins, {}}, mesh.used);
    Vector<VertexId> expected = compact_points(mesh.used, copy_of, &geometry);
    if (expected.empty()) expected = count_up<VertexId>(all);

    for (const std::uint64_t memory :
         {std::uint64_t{1} << 30, 32 * all / 3 + 1, std::uint64_t{700}}) {
      PieceNumbers numbers(all);
      for (VertexId v = 0; v < all; ++v) {
        if (mesh.used[v] != 0) numbers.use(v);
      }
      numbers.find_copies(
          mesh.begins,
          [&](std::uint64_t first, std::uint64_t count, PointKey* out) {
            for (std::uint64_t i = 0; i < count; ++i) {
              const Vec3<double>& p = mesh.points[first + i];
              out[i] = key_of_coordinates(p.x, p.y, p.z);
            }
          },
          memory);
      ASSERT_EQ(numbers.points(), point_count(geometry.points));
      EXPECT_EQ(numbers.merged(), geometry.merged_points);
      EXPECT_EQ(numbers.unused(), geometry.unused_points);
      std::uint64_t next = 0;
      for (VertexId v = 0; v < all; ++v) {
        if (mesh.used[v] != 0) {
          ASSERT_EQ(numbers.number(v), expected[v]) << seed << " " << v;
        }
        if (numbers.stays(v)) {
          ASSERT_EQ(numbers.point_of(next++), v);
        }
      }
      EXPECT_EQ(next, numbers.points());
      EXPECT_EQ(numbers.point_of(next), all);
      EXPECT_LE(numbers.bytes(), all / 4 + 8 * numbers.merged() + 100);
    }
  }
}

TEST(PieceNumbers, OfNoPoints) {
  PieceNumbers numbers(0);
  numbers.find_copies(std::vector<std::uint64_t>{0}, {}, 0);
  EXPECT_EQ(numbers.points(), 0u);
  EXPECT_EQ(numbers.point_of(0), 0u);
}

}  // namespace
}  // namespace tetfusion
