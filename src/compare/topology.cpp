#include "compare/topology.h"

#include <algorithm>

#include "mesh/union_find.h"

namespace tetfusion {

SurfaceTopology topology_of(const TriangleSet& set) {
  UnionFind parts(set.points.size());
  Vector<std::uint64_t> edges;
  edges.reserve(3 * set.triangles.size());
  for (const auto& triangle : set.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      edges.push_back(std::uint64_t{low} << 32 | high);
      parts.unite(low, high);
    }
  }
  std::sort(edges.begin(), edges.end());
  const auto end = std::unique(edges.begin(), edges.end());
  SurfaceTopology result;
  result.euler = static_cast<std::int64_t>(set.points.size() + set.triangles.size()) -
                 static_cast<std::int64_t>(end - edges.begin());
  for (std::uint32_t p = 0; p < set.points.size(); ++p) result.parts += parts.find(p) == p ? 1 : 0;
  return result;
}

}  // namespace tetfusion
