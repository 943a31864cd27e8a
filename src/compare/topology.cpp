#include "compare/topology.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/blocks.h"
#include "base/union_find.h"
#include "mesh/incidence.h"

namespace tetfusion {

namespace {

constexpr std::size_t kPointsPerBlock = 4096;

}  // namespace

SurfaceTopology topology_of(const TriangleSet& set) {
  const std::size_t points = set.points.size();
  Vector<std::uint32_t> begins, corners;
  build_incidence<3>(points, set.triangles, &begins, &corners);
  UnionFind parts(points);
  std::vector<std::int64_t> edges(block_count(points, kPointsPerBlock), 0);  // to larger numbers
  for_each_block(points, kPointsPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> others;
    for (std::size_t p = begin; p < end; ++p) {
      others.clear();
      for (std::uint32_t i = begins[p]; i < begins[p + 1]; ++i) {
        for (const std::uint32_t other : set.triangles[corners[i] / 3]) {
          if (other > p) others.push_back(other);
        }
      }
      std::sort(others.begin(), others.end());
      others.erase(std::unique(others.begin(), others.end()), others.end());
      edges[b] += static_cast<std::int64_t>(others.size());
      for (const std::uint32_t other : others) parts.unite(static_cast<std::uint32_t>(p), other);
    }
  });
  SurfaceTopology result;
  result.euler = static_cast<std::int64_t>(points + set.triangles.size());
  for (const std::int64_t count : edges) result.euler -= count;
  for (std::uint32_t p = 0; p < points; ++p) result.parts += parts.is_root(p) ? 1 : 0;
  return result;
}

}  // namespace tetfusion
