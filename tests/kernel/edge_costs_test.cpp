#include "kernel/quadrics/edge_costs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "kernel/quadrics/cost_queue.h"
#include "support/fuse_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_cube;
using testing::kUnit;
using testing::smooth;
using testing::Steered;
using testing::steered;

// In any group of lanes the cost is that of one edge alone, to the bit, and that is what the merged
// quadric says.
TEST(EdgeCosts, DoNotDependOnTheLane) {
  for (const std::size_t width : {1, 2}) {
    Steered s = steered(five_split_cube(4, 0.2, 3), smooth);
    std::vector<SteeringField> fields{s.field};
    if (width == 2) {
      fields.push_back({1, 1, s.field.range, {}});
      Vector<double> both;
      for (const double x : s.mesh.steering) both.insert(both.end(), {x, x * x / 4});
      s.mesh.steering = both;
      s.mesh.steering_width = 2;
      begin_quadrics(fields, kUnit, &s.mesh);
    }
    EdgeCosts<double> costs;
    costs.begin(&s.mesh, fields, kUnit);
    std::vector<VertexId> partners(23);
    std::iota(partners.begin(), partners.end(), VertexId{40});
    std::vector<float> together(partners.size());
    costs.between(3, partners, together.data());
    for (std::size_t i = 0; i < partners.size(); ++i) {
      float alone = -1;
      costs.between(3, {&partners[i], 1}, &alone);
      EXPECT_EQ(together[i], alone);
      MergedQuadric m;
      costs.merge(3, partners[i], &m);
      const float squares = std::max(value_at(m.reduced, m.best), 0.0F);
      EXPECT_EQ(alone, squares / m.sum[kQuadricW] + 1e-6F * dot(m.edge.data(), m.edge));
      EXPECT_GT(alone, 0);
    }
  }
}

// A linear field tells nothing apart. Where gradients are uncertain the two stand for that many
// tetrahedra each that lie so far away: at their common centre the squares are least.
TEST(EdgeCosts, GradientsVarianceMakesFarOnesDear) {
  constexpr float kVariance = 0.25F;
  Steered s = steered(five_split_cube(4, 0.2, 3), testing::linear);
  EdgeCosts<double> costs;
  costs.begin(&s.mesh, s.fields(), kUnit);
  const auto cost_of = [&](VertexId v, VertexId partner) {
    float cost = -1;
    costs.between(v, {&partner, 1}, &cost);
    return cost;
  };
  for (VertexId v = 20; v < 90; v += 7) EXPECT_LT(cost_of(3, v), 3e-6F);
  for (std::size_t at = 0; at < s.mesh.quadrics.size(); at += s.mesh.quadric_width) {
    add_gradient_variance(kVariance, s.mesh.quadrics.data() + at);
  }
  const auto weight = [&](VertexId v) {
    return double{s.mesh.quadrics[v * s.mesh.quadric_width + kQuadricW]};
  };
  for (VertexId v = 20; v < 90; v += 7) {
    const Offset edge = costs.offset(s.mesh.positions[3], s.mesh.positions[v]);
    const double all = weight(3) + weight(v);
    const double least =
        double{kVariance} * double{dot(edge.data(), edge)} * weight(3) * weight(v) / (all * all);
    EXPECT_GE(cost_of(3, v), 0.999 * least);
    EXPECT_LE(cost_of(3, v), 1.05 * least);
  }
}

// Across the plane nothing but the bend says where to go, along it nothing at all: there the middle
// of the edge is taken, and it must not draw the vertex out of the plane.
TEST(EdgeCosts, StayInThePlaneWhereAFieldBends) {
  constexpr double kPlane = 2;
  Steered s = steered(five_split_cube(4, 0, 1),
                      [](double, double, double z) { return std::max(z - kPlane, 0.0); });
  EdgeCosts<double> costs;
  costs.begin(&s.mesh, s.fields(), kUnit);
  int seen = 0;
  for (const Tet& tet : s.mesh.tets) {
    for (const VertexId v : tet) {
      for (const VertexId u : tet) {
        const Vec3<double>&p = s.mesh.positions[v], &q = s.mesh.positions[u];
        if (p.z != kPlane || q.z == kPlane) continue;
        MergedQuadric m;
        costs.merge(v, u, &m);
        const Vec3<double> best = costs.position_at(v, m.best);
        EXPECT_NEAR(best.x, (p.x + q.x) / 2, 1e-3);
        EXPECT_NEAR(best.y, (p.y + q.y) / 2, 1e-3);
        EXPECT_NEAR(best.z, kPlane, 1e-4);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(CostQueue, TheCheapestComeFirstAndThenThoseWhoCameFirst) {
  CostQueue queue;
  queue.reset(6);
  ASSERT_EQ(queue.blocks(), 1u);
  const std::vector<float> costs{4, 1, 4.1F, 0, 2, 4};
  for (VertexId v = 0; v < costs.size(); ++v) queue.push(v, costs[v]);
  queue.push(4, 0);  // waits already
  std::vector<VertexId> order;
  for (std::size_t bin = 0; bin < CostQueue::kBins; ++bin) {
    queue.go_to(0, bin);
    while (true) {
      const VertexId next = queue.first(0);
      const VertexId v = queue.pop(0);
      EXPECT_EQ(v, next);
      if (v == kNoVertex) break;
      order.push_back(v);
    }
  }
  EXPECT_EQ(order, (std::vector<VertexId>{3, 1, 4, 0, 2, 5}));
  const std::size_t bin = CostQueue::bin_of(3);
  queue.go_to(0, bin);
  queue.push(1, 1);
  queue.push(5, 2);
  EXPECT_EQ(queue.after(1), 5u);
  queue.go_to(0, CostQueue::bin_of(1));
  EXPECT_EQ(queue.pop(0), kNoVertex);
  queue.go_to(0, bin);
  EXPECT_EQ(queue.pop(0), 1u);
}

// Whoever comes to a block that has had its turn waits for the next one, and a block that has not
// is not affected by where others are.
TEST(CostQueue, BlocksHaveBinsOfTheirOwn) {
  CostQueue queue;
  queue.reset(10'000);
  const std::size_t near = CostQueue::block_of(17), far = CostQueue::block_of(9'000);
  ASSERT_LT(near + 1, far);
  ASSERT_EQ(queue.blocks(), CostQueue::block_of(9'999) + 1);
  const std::size_t low = CostQueue::bin_of(1), high = CostQueue::bin_of(100);
  queue.go_to(near, high);
  queue.push(17, 1);
  queue.push(9'000, 1);
  queue.go_to(far, low);
  EXPECT_EQ(queue.pop(far), 9'000u);
  EXPECT_EQ(queue.pop(near + 1), kNoVertex);
  EXPECT_EQ(queue.pop(near), 17u);
}

}  // namespace
}  // namespace tetfusion
