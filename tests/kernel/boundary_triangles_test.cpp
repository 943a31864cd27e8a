#include "kernel/sheets/boundary_triangles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::uniform;
using Corners = BoundaryTriangles::Corners;

// A small triangle at a place.
struct Placed {
  Point3 a, b, c;
  explicit Placed(double x) : a{x, 1.2, 1.2}, b{x, 1.6, 1.2}, c{x, 1.2, 1.6} {}
  Triangle3 place() const { return {a, b, c}; }
};

FacingBox at(double x) { return {{x, 1, 1}, {x, 1.9, 1.9}}; }

std::multiset<Corners> all_in(BoundaryTriangles* triangles, const FacingBox& box) {
  std::multiset<Corners> out;
  triangles->any(box, [&](const Corners& corners) {
    out.insert(corners);
    return false;
  });
  return out;
}

TEST(BoundaryTriangles, KnowsWhereAllAreHere) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {64, 64, 64}});
  for (const double x : {1.5, 3.5, 3.6}) grid.note(Placed(x).a, Placed(x).b, Placed(x).c);
  BoundaryTriangles triangles;
  triangles.begin(grid);
  triangles.note({1, 2, 3}, Placed(1.5).place());
  triangles.note({4, 5, 6}, Placed(3.5).place());
  EXPECT_TRUE(triangles.knows(at(1.5)));
  EXPECT_TRUE(triangles.knows(at(8.5)));  // nobody has any there
  EXPECT_FALSE(triangles.knows(at(3.5)));
  EXPECT_FALSE(triangles.knows({{1, 1, 1}, {4, 1, 1}}));
  // What comes later stands for none of those that are elsewhere.
  triangles.add({7, 8, 9}, Placed(3.6).place());
  EXPECT_FALSE(triangles.knows(at(3.5)));
  triangles.begin(grid);
  EXPECT_FALSE(triangles.knows(at(1.5)));
  EXPECT_TRUE(all_in(&triangles, at(1.5)).empty());
}

TEST(BoundaryTriangles, ComeOnceWhereverTheyReach) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {64, 64, 64}});
  BoundaryTriangles triangles;
  triangles.begin(grid);
  triangles.note({1, 2, 3}, {{{1, 1, 1}, {9, 9, 1}, {9, 1, 1}}});
  triangles.add({4, 5, 6}, Placed(3.5).place());
  const FacingBox everywhere{{0, 0, 0}, {64, 64, 64}};
  EXPECT_EQ(all_in(&triangles, everywhere), (std::multiset<Corners>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(all_in(&triangles, at(3.5)), (std::multiset<Corners>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(all_in(&triangles, {{8.5, 8.5, 1}, {8.5, 8.5, 1}}),
            (std::multiset<Corners>{{1, 2, 3}}));
  int asked = 0;
  EXPECT_TRUE(triangles.any(everywhere, [&](const Corners&) { return ++asked == 1; }));
  EXPECT_EQ(asked, 1);
}

// Of all sizes, along each axis by itself.
TEST(BoundaryTriangles, AreFoundInEachBoxThatTheyReach) {
  FacingGrid grid;
  grid.reset({{0, 0, 0}, {64, 64, 64}});
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::uint64_t i = 0;
    const auto draw = [&] { return uniform(seed, i++); };
    const auto draw_box = [&] {
      FacingBox box{};
      for (std::size_t k = 0; k < 3; ++k) {
        const double size = 64 * std::pow(0.25, 4 * draw());
        box.lo[k] = (64 - size) * draw();
        box.hi[k] = box.lo[k] + size;
      }
      return box;
    };
    BoundaryTriangles triangles;
    triangles.begin(grid);
    std::vector<FacingBox> boxes;
    for (VertexId t = 0; t < 500; ++t) {
      const auto [lo, hi] = boxes.emplace_back(draw_box());
      triangles.add({t, t, t}, {lo, {hi[0], lo[1], hi[2]}, {lo[0], hi[1], hi[2]}});
    }
    EXPECT_LE(triangles.entries(), 8 * boxes.size());
    for (int query = 0; query < 50; ++query) {
      const FacingBox box = draw_box();
      const std::multiset<Corners> found = all_in(&triangles, box);
      for (VertexId t = 0; t < boxes.size(); ++t) {
        bool touches = true;
        for (std::size_t k = 0; k < 3; ++k) {
          touches = touches && boxes[t].lo[k] <= box.hi[k] && box.lo[k] <= boxes[t].hi[k];
        }
        EXPECT_LE(found.count({t, t, t}), 1u);
        EXPECT_TRUE(!touches || found.contains({t, t, t})) << seed << " " << t;
      }
    }
  }
}

}  // namespace
}  // namespace tetfusion
