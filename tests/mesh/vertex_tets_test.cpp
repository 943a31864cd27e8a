#include "mesh/vertex_tets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::uint32_t> of(const VertexTets& m, VertexId v) {
  return {m.of(v).begin(), m.of(v).end()};
}

TEST(VertexTets, ListsTetAndCornerAscending) {
  const Vector<Tet> tets{{0, 1, 2, 3}, {4, 2, 1, 0}};
  VertexTets m;
  build_vertex_tets(6, tets, &m);
  EXPECT_THAT(m.offsets, ElementsAre(0, 2, 4, 6, 7, 8, 8));
  EXPECT_THAT(of(m, 0), ElementsAre(0 << 2 | 0, 1 << 2 | 3));
  EXPECT_THAT(of(m, 1), ElementsAre(0 << 2 | 1, 1 << 2 | 2));
  EXPECT_THAT(of(m, 2), ElementsAre(0 << 2 | 2, 1 << 2 | 1));
  EXPECT_THAT(of(m, 4), ElementsAre(1 << 2 | 0));
  EXPECT_THAT(of(m, 5), IsEmpty());
}

TEST(VertexTets, ARepeatedVertexIsThereTwice) {
  const Vector<Tet> tets{{0, 1, 1, 2}};
  VertexTets m;
  build_vertex_tets(3, tets, &m);
  EXPECT_THAT(of(m, 1), ElementsAre(1, 2));
}

TEST(VertexTets, NoTets) {
  VertexTets m;
  build_vertex_tets(2, {}, &m);
  EXPECT_THAT(m.offsets, ElementsAre(0, 0, 0));
  EXPECT_TRUE(m.entries.empty());
}

TEST(VertexTets, MemoryIsUsedAgain) {
  const Geometry big = testing::five_split_cube(4);
  const Vector<Tet> small{{0, 1, 2, 3}};
  VertexTets m;
  build_vertex_tets(point_count(big.points), big.tets, &m);
  const std::uint32_t* const entries = m.entries.data();
  build_vertex_tets(4, small, &m);
  EXPECT_EQ(m.entries.data(), entries);
  EXPECT_THAT(m.offsets, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(m.entries, ElementsAre(0, 1, 2, 3));
}

TEST(VertexTets, EveryCornerIsThereOnce) {
  const Geometry mesh = testing::kuhn_box(5, 4, 3);
  VertexTets m;
  build_vertex_tets(point_count(mesh.points), mesh.tets, &m);
  std::vector<bool> seen(4 * mesh.tets.size(), false);
  for (VertexId v = 0; v < point_count(mesh.points); ++v) {
    EXPECT_TRUE(std::is_sorted(m.of(v).begin(), m.of(v).end()));
    for (const std::uint32_t e : m.of(v)) {
      EXPECT_EQ(mesh.tets[e >> 2][e & 3], v);
      EXPECT_FALSE(seen[e]);
      seen[e] = true;
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 4 * static_cast<long>(mesh.tets.size()));
}

}  // namespace
}  // namespace tetfusion
