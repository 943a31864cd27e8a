#include "mesh/surface.h"

#include <algorithm>
#include <vector>

#include "mesh/blocks.h"
#include "mesh/incidence.h"
#include "mesh/union_find.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlock = 4096;  // vertices

// The triangles round one vertex, as the edges of its link: triangle i joins its other two
// vertices.
class Umbrella {
 public:
  struct Findings {
    std::uint64_t edges = 0;              // to larger vertices
    std::uint64_t nonmanifold_edges = 0;  // of those, the ones whose triangles are not two
    bool one_fan = false;
  };

  Findings judge(VertexId v, std::span<const Triangle> triangles,
                 std::span<const std::uint32_t> corners) {
    ends_.clear();
    for (const std::uint32_t corner : corners) {
      const Triangle& t = triangles[corner / 3];
      for (std::uint32_t k = 1; k <= 2; ++k) {
        const std::uint64_t vertex = t[(corner + k) % 3];
        ends_.push_back(vertex << 32 | ends_.size());
      }
    }
    std::sort(ends_.begin(), ends_.end());
    return pair_up(v);
  }

 private:
  // Ends 2i and 2i + 1 belong to triangle i. Two ends at the same link vertex are partners.
  Findings pair_up(VertexId v) {
    Findings found;
    bool paired = true;
    partner_.resize(ends_.size());
    for (std::size_t begin = 0, end; begin < ends_.size(); begin = end) {
      const std::uint64_t vertex = ends_[begin] >> 32;
      end = begin + 1;
      while (end < ends_.size() && ends_[end] >> 32 == vertex) ++end;
      if (vertex > v) ++found.edges;
      if (end - begin == 2) {
        const auto a = static_cast<std::uint32_t>(ends_[begin]);
        const auto b = static_cast<std::uint32_t>(ends_[begin + 1]);
        partner_[a] = b;
        partner_[b] = a;
      } else {
        paired = false;
        if (vertex > v) ++found.nonmanifold_edges;
      }
    }
    found.one_fan = paired && fan_size() == ends_.size() / 2;
    return found;
  }

  std::size_t fan_size() const {
    std::size_t triangles = 0;
    std::uint32_t end = 0;
    do {
      end = partner_[end ^ 1u];
      ++triangles;
    } while (end != 0);
    return triangles;
  }

  std::vector<std::uint64_t> ends_;  // link vertex << 32 | end
  std::vector<std::uint32_t> partner_;
};

struct BlockFindings {
  std::uint64_t vertices = 0;
  std::uint64_t edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  FirstIds nonmanifold_edge_samples;
  std::vector<VertexId> nonmanifold_vertices;
};

std::uint64_t count_components(std::span<const Triangle> triangles,
                               const Vector<std::uint32_t>& offsets) {
  UnionFind sets(offsets.size() - 1);
  for (const Triangle& t : triangles) {
    sets.unite(t[0], t[1]);
    sets.unite(t[0], t[2]);
  }
  std::uint64_t components = 0;
  for (std::uint32_t v = 0; v + 1 < offsets.size(); ++v) {
    if (offsets[v] != offsets[v + 1] && sets.is_root(v)) ++components;
  }
  return components;
}

}  // namespace

Surface judge_surface(std::size_t points, std::span<const Triangle> triangles) {
  Surface surface;
  Vector<std::uint32_t> entries;
  build_incidence<3>(points, triangles, &surface.offsets, &entries);
  const auto& offsets = surface.offsets;

  std::vector<BlockFindings> blocks(block_count(points, kBlock));
  for_each_block(points, kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    BlockFindings& found = blocks[b];
    Umbrella umbrella;
    for (std::size_t i = begin; i < end; ++i) {
      if (offsets[i] == offsets[i + 1]) continue;
      const auto v = static_cast<VertexId>(i);
      const auto u = umbrella.judge(v, triangles,
                                    {entries.data() + offsets[i], entries.data() + offsets[i + 1]});
      ++found.vertices;
      found.edges += u.edges;
      found.nonmanifold_edges += u.nonmanifold_edges;
      if (u.nonmanifold_edges > 0) found.nonmanifold_edge_samples.add(v);
      if (!u.one_fan) found.nonmanifold_vertices.push_back(v);
    }
  });
  for (const BlockFindings& found : blocks) {
    surface.vertices += found.vertices;
    surface.edges += found.edges;
    surface.nonmanifold_edges += found.nonmanifold_edges;
    surface.nonmanifold_edge_samples.add(found.nonmanifold_edge_samples);
    surface.nonmanifold_vertices.insert(surface.nonmanifold_vertices.end(),
                                        found.nonmanifold_vertices.begin(),
                                        found.nonmanifold_vertices.end());
  }
  surface.components = count_components(triangles, offsets);
  return surface;
}

}  // namespace tetfusion
