#include "kernel/edge_links.h"

#include <algorithm>
#include <array>

namespace tetfusion {

namespace {

template <class T>
bool has(const std::vector<T>& items, const T& item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

// Of vertices, a few of which may be taken for members though they are none.
class VertexSieve {
 public:
  void add(VertexId v) { words_[place(v) >> 6] |= std::uint64_t{1} << (place(v) & 63u); }
  bool may_have(VertexId v) const { return (words_[place(v) >> 6] >> (place(v) & 63u) & 1u) != 0; }

 private:
  static std::uint32_t place(VertexId v) { return v * 0x9E3779B1u >> 24; }
  std::array<std::uint64_t, 4> words_{};
};

}  // namespace

// A vertex that both links have is of the link of the edge. So are both ends of an edge that both
// have, then: of other edges it need not be asked.
template <class Real>
bool EdgeLinks::are_apart(const WorkMesh<Real>& mesh, LiveBalls* balls, VertexId a, VertexId b) {
  const auto& tets = mesh.tets;
  const auto ball_a = balls->of(a, mesh.incidence[a], tets);
  const auto ball_b = balls->of(b, mesh.incidence[b], tets);
  VertexSieve link_a;
  vertices_.clear();
  edges_.clear();
  for (const std::uint32_t entry : ball_a) {
    const Tet& tet = tets[entry >> 2];
    const bool is_shared = has_corner(tet, b);
    std::array<VertexId, 3> others{};
    std::size_t count = 0;
    for (const VertexId u : tet) {
      link_a.add(u);
      if (!is_shared || u == a || u == b) continue;
      if (!has(vertices_, u)) vertices_.push_back(u);
      others[count++] = u;
    }
    if (is_shared) edges_.push_back(edge_key(others[0], others[1]));
  }
  const auto is_near_a = [&](VertexId u) {
    return link_a.may_have(u) && std::any_of(ball_a.begin(), ball_a.end(), [&](auto entry) {
             return has_corner(tets[entry >> 2], u);
           });
  };
  for (const std::uint32_t entry : ball_b) {
    for (const VertexId u : tets[entry >> 2]) {
      if (u != a && u != b && !has(vertices_, u) && is_near_a(u)) return false;
    }
  }
  if (share_triangle(tets, ball_a, a, ball_b, b)) return false;
  find_other_edges(tets, ball_a, a, &other_edges_of_a_);
  if (other_edges_of_a_.empty()) return true;
  find_other_edges(tets, ball_b, b, &other_edges_of_b_);
  return std::none_of(other_edges_of_a_.begin(), other_edges_of_a_.end(),
                      [&](std::uint64_t edge) { return has(other_edges_of_b_, edge); });
}

// One of vertices of the link of the edge: two tetrahedra would be the same then.
bool EdgeLinks::share_triangle(std::span<const Tet> tets, std::span<const std::uint32_t> ball_a,
                               VertexId a, std::span<const std::uint32_t> ball_b,
                               VertexId b) const {
  if (vertices_.size() < 3) return false;
  const auto is_of_link = [&](const Tet& tet, VertexId of) {
    return std::ranges::all_of(tet, [&](VertexId u) { return u == of || has(vertices_, u); });
  };
  return std::ranges::any_of(ball_a, [&](std::uint32_t entry) {
    const Tet& tet = tets[entry >> 2];
    if (!is_of_link(tet, a)) return false;
    return std::ranges::any_of(ball_b, [&](std::uint32_t other) {
      const Tet& there = tets[other >> 2];
      return is_of_link(there, b) &&
             std::ranges::all_of(tet, [&](VertexId u) { return u == a || has_corner(there, u); });
    });
  });
}

// Those of the vertex's link that join vertices of the link of the edge, but are none of its edges.
void EdgeLinks::find_other_edges(std::span<const Tet> tets, std::span<const std::uint32_t> ball,
                                 VertexId of, std::vector<std::uint64_t>* edges) const {
  edges->clear();
  for (const std::uint32_t entry : ball) {
    std::array<VertexId, 3> ends{};
    std::size_t count = 0;
    for (const VertexId u : tets[entry >> 2]) {
      if (u != of && has(vertices_, u)) ends[count++] = u;
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = i + 1; k < count; ++k) {
        const std::uint64_t edge = edge_key(ends[i], ends[k]);
        if (!has(edges_, edge)) edges->push_back(edge);
      }
    }
  }
}

template bool EdgeLinks::are_apart(const WorkMesh<float>&, LiveBalls*, VertexId, VertexId);
template bool EdgeLinks::are_apart(const WorkMesh<double>&, LiveBalls*, VertexId, VertexId);

}  // namespace tetfusion
