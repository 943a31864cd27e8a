// Which fusions a region takes, on logs that are written down here.
#include "refine/fusion_needs.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tetfusion {
namespace {

// A row of edges: point i and i + 1, with two more of their own, are tetrahedron i. As records only
// say what they change, the mesh need not be one that could be simplified so.
class Needs : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kTets = 6;
  Needs() {
    PointRows points;
    for (VertexId v = 0; v < 4 * kTets; ++v) points.numbers.push_back(v);
    points.rows.resize(points.numbers.size());
    mesh.add_points(points);
    TetRows tets;
    for (TetId t = 0; t < kTets; ++t) {
      tets.numbers.push_back(t);
      tets.corners.push_back({4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3});
    }
    mesh.add_tets(tets);
  }
  // Undoes a fusion into `kept` that moved it, or made another corner of these; `gone` came of it.
  void add(VertexId kept, VertexId gone, const std::vector<TetId>& star,
           const std::vector<std::uint8_t>& whose, const std::vector<TetId>& back, bool moved) {
    FusionRecord record;
    record.kept = kept;
    record.gone = 1;
    record.points = {&gone, 1};
    record.star = whose;
    record.tets = back;
    needs.add(record, moved, star);
  }
  std::vector<int> of(std::vector<VertexId> points) {
    Vector<std::uint8_t> inside(4 * kTets, std::uint8_t{0});
    for (const VertexId v : points) inside[v] = 1;
    const auto needed = needs.of_region(mesh, inside);
    return {needed.begin(), needed.end()};
  }

  RefinableMesh mesh{{4 * kTets, kTets, kTets, 0, 0, 0}, 1, 0, [](const std::string& what) {
                       throw std::runtime_error(what);
                     }};
  FusionNeeds needs{4 * kTets, kTets};
};

TEST_F(Needs, NothingWhereNothingHasChanged) {
  EXPECT_EQ(of({0, 5}), std::vector<int>{});
  add(0, 1, {0, 1}, {1, 0}, {2}, false);
  EXPECT_EQ(of({12}), std::vector<int>{0});
}

TEST_F(Needs, WhatMovedATetrahedronOrBroughtItBack) {
  add(0, 1, {0, 1}, {1, 0}, {2}, false);
  EXPECT_EQ(of({3}), std::vector<int>{1}) << "its corner is another one";
  EXPECT_EQ(of({4}), std::vector<int>{0}) << "it stays as it is";
  EXPECT_EQ(of({9}), std::vector<int>{1}) << "it comes back";
  add(5, 6, {1}, {0}, {3}, true);
  EXPECT_EQ(of({4}), (std::vector<int>{0, 1})) << "its corner moved";
}

TEST_F(Needs, WhatThatNeedsAgain) {
  add(0, 1, {0}, {1}, {2}, false);
  add(8, 9, {2, 3}, {0, 1}, {4}, false);  // its star came back with the first
  add(13, 14, {3}, {1}, {5}, false);      // its star was changed by the second
  add(20, 21, {1}, {1}, {}, false);       // has nothing to do with any
  EXPECT_EQ(of({22}), (std::vector<int>{1, 1, 1, 0}));
  EXPECT_EQ(of({17}), (std::vector<int>{1, 1, 0, 0}));
  EXPECT_EQ(of({7}), (std::vector<int>{0, 0, 0, 1}));
}

// Two fusions into one point, and one whose tetrahedra name a point elsewhere.
TEST_F(Needs, Points) {
  add(0, 1, {}, {}, {0}, false);
  add(0, 2, {}, {}, {1}, false);
  EXPECT_EQ(of({4}), (std::vector<int>{1, 1}));
  FusionRecord record;
  record.kept = 9;
  const VertexId gone = 10, elsewhere = 1;
  const TetId back = 3;
  record.points = {&gone, 1};
  record.elsewhere = {&elsewhere, 1};
  record.tets = {&back, 1};
  needs.add(record, false, {});
  EXPECT_EQ(of({12}), (std::vector<int>{1, 0, 1}));
}

}  // namespace
}  // namespace tetfusion
