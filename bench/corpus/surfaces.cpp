#include "surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace corpus {

namespace {

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// On the edge from corner i to corner k.
Nearest nearest_on_edge(const Point& p, const std::array<Point, 3>& t, std::size_t i,
                        std::size_t k) {
  const Point edge = minus(t[k], t[i]), to = minus(p, t[i]);
  const double squared = dot(edge, edge);
  const double share = squared > 0 ? std::clamp(dot(to, edge) / squared, 0.0, 1.0) : 0;
  const Point rest{to[0] - share * edge[0], to[1] - share * edge[1], to[2] - share * edge[2]};
  Nearest result{std::sqrt(dot(rest, rest)), {}};
  result.weights[i] = 1 - share;
  result.weights[k] = share;
  return result;
}

}  // namespace

Nearest nearest_on(const Point& p, const std::array<Point, 3>& t) {
  Nearest best = nearest_on_edge(p, t, 0, 1);
  for (const Nearest& other : {nearest_on_edge(p, t, 1, 2), nearest_on_edge(p, t, 2, 0)}) {
    if (other.distance < best.distance) best = other;
  }
  const Point normal = cross(minus(t[1], t[0]), minus(t[2], t[0]));
  const double squared = dot(normal, normal);
  if (!(squared > 0)) return best;
  Nearest inside{std::abs(dot(minus(p, t[0]), normal)) / std::sqrt(squared), {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Point &a = t[(i + 1) % 3], &b = t[(i + 2) % 3];
    inside.weights[i] = dot(cross(minus(b, a), minus(p, a)), normal) / squared;
    if (inside.weights[i] < 0) return best;
  }
  return inside.distance < best.distance ? inside : best;
}

Faces faces_of(const std::vector<Tet>& tets) {
  Faces faces;
  for (std::size_t c = 0; c < tets.size(); ++c) {
    Tet t = tets[c];
    std::sort(t.begin(), t.end());
    if (std::adjacent_find(t.begin(), t.end()) != t.end()) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      Face face{};
      for (std::size_t k = 0, at = 0; k < 4; ++k) {
        if (k != i) face[at++] = t[k];
      }
      faces[face].push_back(c);
    }
  }
  return faces;
}

Topology topology_of(const std::vector<Face>& faces) {
  std::map<std::pair<std::int64_t, std::int64_t>, int> edges;
  std::map<std::int64_t, std::int64_t> up;
  const std::function<std::int64_t(std::int64_t)> root = [&](std::int64_t v) {
    while (up[v] != v) v = up[v] = up[up[v]];
    return v;
  };
  for (const Face& f : faces) {
    for (const std::int64_t v : f) up.try_emplace(v, v);
    for (std::size_t i = 0; i < 3; ++i) {
      ++edges[std::minmax(f[i], f[(i + 1) % 3])];
      up[root(f[i])] = root(f[(i + 1) % 3]);
    }
  }
  Topology t;
  for (const auto& [v, parent] : up) t.parts += v == parent ? 1 : 0;
  for (const auto& [edge, count] : edges) t.odd_edges += count != 2 ? 1 : 0;
  t.euler = static_cast<long>(up.size() + faces.size()) - static_cast<long>(edges.size());
  return t;
}

double farthest(const Triangles& from, const Triangles& to) {
  double most = 0;
  std::set<Point> places;
  for (const auto& t : from) {
    places.insert(t.begin(), t.end());
    places.insert({(t[0][0] + t[1][0] + t[2][0]) / 3, (t[0][1] + t[1][1] + t[2][1]) / 3,
                   (t[0][2] + t[1][2] + t[2][2]) / 3});
  }
  for (const Point& p : places) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& t : to) {
      // Never less than this.
      double away = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax({t[0][i], t[1][i], t[2][i]});
        away = std::max({away, low - p[i], p[i] - high});
      }
      if (away < best) best = std::min(best, nearest_on(p, t).distance);
      if (best <= most) break;
    }
    most = std::max(most, best);
  }
  return most;
}

}  // namespace corpus
