#include "support/brute_check.h"

#include <algorithm>
#include <map>
#include <variant>
#include <vector>

namespace tetfusion::testing {

namespace {

using Key = std::array<VertexId, 3>;
using Real = long double;

class Checker {
 public:
  explicit Checker(const Geometry& mesh) : mesh_(mesh) {}

  BruteReport run() {
    check_cells();
    check_faces();
    count_components();
    check_surface();
    return report_;
  }

 private:
  struct Side {
    std::size_t cell;
    VertexId apex;
  };

  std::array<Real, 3> at(VertexId v) const {
    return std::visit(
        [v](const auto& p) {
          return std::array<Real, 3>{Real{p[v].x}, Real{p[v].y}, Real{p[v].z}};
        },
        mesh_.points);
  }

  Real six_volumes(VertexId a, VertexId b, VertexId c, VertexId d) const {
    const auto o = at(a), p = at(b), q = at(c), r = at(d);
    std::array<std::array<Real, 3>, 3> m{};
    for (std::size_t k = 0; k < 3; ++k) m[k] = {p[k] - o[k], q[k] - o[k], r[k] - o[k]};
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  }

  void check_cells() {
    std::set<std::array<VertexId, 4>> seen;
    for (std::size_t i = 0; i < mesh_.tets.size(); ++i) {
      const Tet& t = mesh_.tets[i];
      Tet sorted = t;
      std::sort(sorted.begin(), sorted.end());
      const bool twice = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
      const Real det = twice ? 0 : six_volumes(t[0], t[1], t[2], t[3]);
      (det > 0 ? report_.positive : det < 0 ? report_.negative : report_.zero) += 1;
      report_.volume += (det < 0 ? -det : det) / 6;
      has_volume_.push_back(det != 0);
      if (twice) continue;
      if (!seen.insert(sorted).second) ++report_.duplicates;
      for (std::size_t k = 0; k < 4; ++k) {
        Key face{};
        for (std::size_t j = 0, n = 0; j < 4; ++j) {
          if (j != k) face[n++] = sorted[j];
        }
        faces_[face].push_back({i, sorted[k]});
      }
    }
  }

  void check_faces() {
    for (const auto& [face, sides] : faces_) {
      if (sides.size() == 1) report_.boundary.insert(face);
      if (sides.size() > 2) ++report_.overfull;
      if (sides.size() != 2 || sides[0].apex == sides[1].apex) continue;
      if (!has_volume_[sides[0].cell] || !has_volume_[sides[1].cell]) continue;
      const Real a = six_volumes(face[0], face[1], face[2], sides[0].apex);
      const Real b = six_volumes(face[0], face[1], face[2], sides[1].apex);
      if ((a > 0) == (b > 0)) ++report_.foldover;
    }
  }

  void count_components() {
    std::vector<std::vector<std::size_t>> next(mesh_.tets.size());
    for (const auto& [face, sides] : faces_) {
      for (const Side& a : sides) {
        for (const Side& b : sides) next[a.cell].push_back(b.cell);
      }
    }
    std::vector<bool> seen(mesh_.tets.size(), false);
    for (std::size_t start = 0; start < seen.size(); ++start) {
      if (seen[start]) continue;
      ++report_.components;
      std::vector<std::size_t> stack{start};
      seen[start] = true;
      while (!stack.empty()) {
        const std::size_t t = stack.back();
        stack.pop_back();
        for (const std::size_t u : next[t]) {
          if (!seen[u]) stack.push_back(u);
          seen[u] = true;
        }
      }
    }
  }

  void check_surface() {
    std::map<std::array<VertexId, 2>, std::size_t> edges;
    std::map<VertexId, std::vector<std::array<VertexId, 2>>> links;  // edges opposite to a vertex
    for (const Key& f : report_.boundary) {
      ++edges[{f[0], f[1]}];
      ++edges[{f[0], f[2]}];
      ++edges[{f[1], f[2]}];
      links[f[0]].push_back({f[1], f[2]});
      links[f[1]].push_back({f[0], f[2]});
      links[f[2]].push_back({f[0], f[1]});
    }
    for (const auto& [edge, triangles] : edges) report_.nonmanifold_edges += triangles != 2 ? 1 : 0;
    for (const auto& [vertex, link] : links) {
      report_.nonmanifold_vertices += is_one_circle(link) ? 0 : 1;
    }
  }

  static bool is_one_circle(const std::vector<std::array<VertexId, 2>>& link) {
    std::map<VertexId, std::set<VertexId>> next;
    std::map<VertexId, int> degree;
    for (const auto& [a, b] : link) {
      next[a].insert(b);
      next[b].insert(a);
      ++degree[a];
      ++degree[b];
    }
    std::set<VertexId> seen{link[0][0]};
    std::vector<VertexId> stack{link[0][0]};
    while (!stack.empty()) {
      const VertexId v = stack.back();
      stack.pop_back();
      for (const VertexId w : next[v]) {
        if (seen.insert(w).second) stack.push_back(w);
      }
    }
    return seen.size() == next.size() &&
           std::all_of(degree.begin(), degree.end(), [](const auto& d) { return d.second == 2; });
  }

  const Geometry& mesh_;
  std::map<Key, std::vector<Side>> faces_;
  std::vector<bool> has_volume_;
  BruteReport report_;
};

}  // namespace

BruteReport brute_check(const Geometry& mesh) { return Checker(mesh).run(); }

}  // namespace tetfusion::testing
