#include "mesh/inspection/surface.h"

#include <algorithm>
#include <vector>

#include "base/blocks.h"
#include "base/union_find.h"
#include "mesh/incidence.h"

namespace tetfusion {

namespace {

constexpr std::size_t kVerticesPerBlock = 4096;

// The triangles round one vertex, as the edges of its link: triangle i joins its other two
// vertices.
class Umbrella {
 public:
  struct Findings {
    std::uint64_t edges = 0;              // ours
    std::uint64_t nonmanifold_edges = 0;  // of those, the ones whose triangles are not two
    bool one_fan = false;
  };

  // is_ours(v, w): whether the edge is to be counted.
  template <class IsOurs>
  Findings judge(VertexId v, std::span<const Triangle> triangles,
                 std::span<const std::uint32_t> corners, const IsOurs& is_ours) {
    ends_.clear();
    for (const std::uint32_t corner : corners) {
      const Triangle& t = triangles[corner / 3];
      for (std::uint32_t k = 1; k <= 2; ++k) {
        const std::uint64_t vertex = t[(corner + k) % 3];
        ends_.push_back(vertex << 32 | ends_.size());
      }
    }
    std::sort(ends_.begin(), ends_.end());
    return pair_up(v, is_ours);
  }

 private:
  // Ends 2i and 2i + 1 belong to triangle i. Two ends at the same link vertex are partners.
  template <class IsOurs>
  Findings pair_up(VertexId v, const IsOurs& is_ours) {
    Findings found;
    bool paired = true;
    partner_.resize(ends_.size());
    for (std::size_t begin = 0, end; begin < ends_.size(); begin = end) {
      const auto vertex = static_cast<VertexId>(ends_[begin] >> 32);
      end = begin + 1;
      while (end < ends_.size() && ends_[end] >> 32 == vertex) ++end;
      if (is_ours(v, vertex)) ++found.edges;
      if (end - begin == 2) {
        const auto a = static_cast<std::uint32_t>(ends_[begin]);
        const auto b = static_cast<std::uint32_t>(ends_[begin + 1]);
        partner_[a] = b;
        partner_[b] = a;
      } else {
        paired = false;
        if (is_ours(v, vertex)) ++found.nonmanifold_edges;
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

// Judges the vertices begin up to end and adds what it finds to `surface`.
template <class IsOurs>
void judge_vertices(std::span<const Triangle> triangles, const Vector<std::uint32_t>& offsets,
                    const Vector<std::uint32_t>& entries, std::size_t begin, std::size_t end,
                    const IsOurs& is_ours, Umbrella* umbrella, Surface* surface) {
  for (std::size_t i = begin; i < end; ++i) {
    if (offsets[i] == offsets[i + 1]) continue;
    const auto v = static_cast<VertexId>(i);
    const auto u = umbrella->judge(
        v, triangles, {entries.data() + offsets[i], entries.data() + offsets[i + 1]}, is_ours);
    ++surface->vertices;
    surface->edges += u.edges;
    surface->nonmanifold_edges += u.nonmanifold_edges;
    if (u.nonmanifold_edges > 0) surface->nonmanifold_edge_samples.add(v);
    if (!u.one_fan) surface->nonmanifold_vertices.push_back(v);
  }
}

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

  const auto is_ours = [](VertexId v, VertexId w) { return w > v; };
  std::vector<Surface> blocks(block_count(points, kVerticesPerBlock));
  for_each_block(points, kVerticesPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    Umbrella umbrella;
    judge_vertices(triangles, surface.offsets, entries, begin, end, is_ours, &umbrella, &blocks[b]);
  });
  for (const Surface& found : blocks) {
    surface.vertices += found.vertices;
    surface.edges += found.edges;
    surface.nonmanifold_edges += found.nonmanifold_edges;
    surface.nonmanifold_edge_samples.add(found.nonmanifold_edge_samples);
    surface.nonmanifold_vertices.insert(surface.nonmanifold_vertices.end(),
                                        found.nonmanifold_vertices.begin(),
                                        found.nonmanifold_vertices.end());
  }
  surface.components = count_components(triangles, surface.offsets);
  return surface;
}

Surface judge_surface_part(const SurfacePart& part, std::span<const Triangle> triangles) {
  Surface surface;
  Vector<std::uint32_t> entries;
  build_incidence<3>(part.foreign.size(), triangles, &surface.offsets, &entries);

  const auto is_ours = [&](VertexId v, VertexId w) {
    return part.foreign[w] != 0 ? part.mixed_edges : w > v;
  };
  Umbrella umbrella;
  for (std::size_t v = 0; v < part.foreign.size(); ++v) {
    if (part.foreign[v] != 0) continue;
    judge_vertices(triangles, surface.offsets, entries, v, v + 1, is_ours, &umbrella, &surface);
  }
  return surface;
}

}  // namespace tetfusion
