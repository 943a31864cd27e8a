#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "shape_tools.h"

namespace corpus {

Shape delaunay_ball(Numbers* n) {
  std::vector<Point> points;
  for (std::size_t i = 40 + n->below(260); i > 0; --i) points.push_back(in_ball(n));
  return delaunay(points);
}

Shape five(Numbers* n) { return jittered(n, lattice(size_of(n, 3, 9), false)); }

Shape kuhn(Numbers* n) { return jittered(n, lattice(size_of(n, 3, 8), true)); }

Shape single(Numbers*) { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}; }

namespace {

// ---- Random Delaunay meshes ----

// Dense in some places: cells of very different sizes.
Shape delaunay_clusters(Numbers* n) {
  std::vector<Point> points;
  for (std::size_t i = 2 + n->below(4); i > 0; --i) {
    const Point centre = in_ball(n);
    const double size = std::pow(10.0, n->between(-4, 0));
    for (std::size_t k = 10 + n->below(40); k > 0; --k) {
      Point p = in_ball(n);
      for (std::size_t c = 0; c < 3; ++c) p[c] = centre[c] + size * p[c];
      points.push_back(p);
    }
  }
  return delaunay(points);
}

// Nearly on a grid, where Delaunay tetrahedra are slivers.
Shape delaunay_slivers(Numbers* n) {
  std::vector<Point> points;
  const double off = std::pow(10.0, n->between(-12, -1));
  const Cube size = size_of(n, 3, 5);
  for (int i = 0; i < size[0]; ++i) {
    for (int j = 0; j < size[1]; ++j) {
      for (int k = 0; k < size[2]; ++k) {
        points.push_back({i + off * n->uniform(), j + off * n->uniform(), k + off * n->uniform()});
      }
    }
  }
  n->shuffle(&points);
  return delaunay(points);
}

// On a sphere, with a few inside.
Shape delaunay_sphere(Numbers* n) {
  std::vector<Point> points;
  for (std::size_t i = 30 + n->below(90); i > 0; --i) {
    Point p = in_ball(n);
    const double r = std::hypot(p[0], p[1], p[2]);
    if (i % 4 != 0) {
      for (double& c : p) c /= r;
    }
    points.push_back(p);
  }
  return delaunay(points);
}

// A thin layer: all points near a plane.
Shape delaunay_sheet(Numbers* n) {
  std::vector<Point> points;
  const double thick = std::pow(10.0, n->between(-6, -1));
  for (std::size_t i = 40 + n->below(80); i > 0; --i) {
    points.push_back({n->uniform(), n->uniform(), thick * n->uniform()});
  }
  return delaunay(points);
}

// ---- Lattices ----

Shape coarse(Numbers* n) { return jittered(n, lattice(size_of(n, 1, 2), n->chance(0.5))); }
Shape plate(Numbers* n) {
  return jittered(n, lattice({9, 11, 1 + static_cast<int>(n->below(2))}, n->chance(0.5)));
}
Shape beam(Numbers* n) { return jittered(n, lattice({2, 2, 30}, n->chance(0.5))); }

// Body-centred: two lattices in each other, four cells round each edge between centres.
Shape bcc(Numbers* n) {
  const Cube size = size_of(n, 3, 7);
  Shape s;
  std::map<Point, std::int64_t> ids;
  const auto id = [&](const Point& p) {
    const auto [at, added] = ids.try_emplace(p, static_cast<std::int64_t>(s.points.size()));
    if (added) s.points.push_back(p);
    return at->second;
  };
  for (int i = 0; i < size[0]; ++i) {
    for (int j = 0; j < size[1]; ++j) {
      for (int k = 0; k < size[2]; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const Cube here{i, j, k};
          if (here[axis] + 1 >= size[axis]) continue;
          Point a{i + 0.5, j + 0.5, k + 0.5}, b = a;
          b[axis] += 1;
          const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
          const auto corner = [&](int du, int dv) {
            Point p = a;
            p[axis] += 0.5;
            p[u] += du - 0.5;
            p[v] += dv - 0.5;
            return id(p);
          };
          const std::array<std::int64_t, 4> ring{corner(0, 0), corner(1, 0), corner(1, 1),
                                                 corner(0, 1)};
          for (std::size_t r = 0; r < 4; ++r)
            s.tets.push_back({id(a), id(b), ring[r], ring[(r + 1) % 4]});
        }
      }
    }
  }
  wind(&s);
  return jittered(n, s, 0.3);
}

Shape layers(Numbers* n) {
  Shape s = jittered(n, lattice({6, 6, 8}, n->chance(0.5)), 0.4);
  const double growth = n->between(1, 3);
  for (Point& p : s.points) p[2] = std::exp2(growth * p[2]) * 1e-4;
  return s;
}

// Bent, so that its boundary is curved.
Shape bent(Numbers* n) {
  Shape s = lattice({10, 6, 4}, n->chance(0.5));
  for (Point& p : s.points) {
    const double angle = p[0] * 0.35, r = 6 + p[1];
    p = {r * std::sin(angle), r * std::cos(angle), p[2] + 0.3 * std::sin(p[0])};
  }
  wind(&s);
  return s;
}

// ---- Holes, tunnels, parts ----

Shape torus(Numbers* n) {
  return jittered(n,
                  lattice({6, 6, 3}, n->chance(0.5),
                          [](int i, int j, int) { return !(i >= 2 && i < 4 && j >= 2 && j < 4); }),
                  0.3);
}
Shape cavity(Numbers* n) {
  return jittered(
      n,
      lattice({6, 5, 5}, n->chance(0.5),
              [](int i, int j, int k) { return !(i >= 2 && i < 4 && j == 2 && k == 2); }),
      0.3);
}
// Cubes missing at random: pinched at edges and vertices.
Shape sponge(Numbers* n) {
  std::vector<std::uint8_t> gone(7 * 7 * 7);
  const double share = n->between(0.02, 0.6);
  for (auto& g : gone) g = n->chance(share) ? 1 : 0;
  gone[0] = 0;
  return jittered(n,
                  lattice({7, 7, 7}, n->chance(0.5),
                          [&](int i, int j, int k) {
                            return gone[static_cast<std::size_t>((k * 7 + j) * 7 + i)] == 0;
                          }),
                  0.3);
}
Shape nested_shells(Numbers* n) {
  const auto hollow = [](int i, int j, int k) {
    const auto inside = [](int c) { return c >= 2 && c < 5; };
    return !(inside(i) && inside(j) && inside(k));
  };
  Shape s = lattice({7, 7, 7}, n->chance(0.5), hollow);
  double scale = 2.0 / 7, at = 2.5;
  for (std::size_t i = n->below(3); i > 0; --i) {
    s = joined(s, moved(lattice({7, 7, 7}, n->chance(0.5), hollow), {at, at, at}, scale));
    at += 2.5 * scale;
    scale *= 2.0 / 7;
  }
  return s;
}
Shape many_parts(Numbers* n) {
  Shape s;
  for (std::size_t i = 2 + n->below(25); i > 0; --i) {
    const Shape part = lattice(size_of(n, 1, 3), n->chance(0.5));
    s = joined(s,
               moved(part, {4.0 * static_cast<double>(i % 3), 4.0 * static_cast<double>(i / 3 % 3),
                            4.0 * static_cast<double>(i / 9)}));
  }
  return s;
}
// Cubes that touch, but share no points.
Shape unwelded(Numbers* n) {
  Shape s;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 3; ++j) {
      s = joined(s, moved(lattice({2, 2, 2}, n->chance(0.5)), {2.0 * i, 2.0 * j, 0}));
    }
  }
  return s;
}
Shape two_at_a_vertex(Numbers* n) {
  const Shape a = lattice({4, 4, 4}, n->chance(0.5)), b = moved(a, {4, 4, 4});
  return welded(joined(a, b), [](const Point& p) { return p == Point{4, 4, 4}; });
}
Shape two_at_an_edge(Numbers* n) {
  const Shape a = lattice({4, 4, 4}, n->chance(0.5)), b = moved(a, {4, 4, 0});
  return welded(joined(a, b), [](const Point& p) { return p[0] == 4 && p[1] == 4; });
}
Shape pinched_chain(Numbers* n) {
  Shape s;
  const int links = 3 + static_cast<int>(n->below(6));
  for (int i = 0; i < links; ++i)
    s = joined(s, moved(lattice({2, 2, 2}, true), {2.0 * i, 2.0 * i, 2.0 * i}));
  return welded(s, [](const Point& p) { return p[0] == p[1] && p[1] == p[2]; });
}
// A sheet inside along which the two sides share no points.
Shape crack(Numbers* n) {
  Shape s = lattice({6, 6, 6}, n->chance(0.5));
  const bool through = n->chance(0.3);
  std::map<std::int64_t, std::int64_t> copies;
  for (std::size_t v = 0, end = s.points.size(); v < end; ++v) {
    const Point p = s.points[v];
    const auto inner = [](double c) { return c > 1 && c < 5; };
    if (p[2] != 3 || (!through && !(inner(p[0]) && inner(p[1])))) continue;
    copies[static_cast<std::int64_t>(v)] = static_cast<std::int64_t>(s.points.size());
    s.points.push_back(p);
  }
  for (Tet& t : s.tets) {
    double sum = 0;
    for (const std::int64_t v : t) sum += s.points[static_cast<std::size_t>(v)][2];
    if (sum <= 12) continue;
    for (std::int64_t& v : t) {
      if (const auto copy = copies.find(v); copy != copies.end()) v = copy->second;
    }
  }
  return s;
}

// ---- Tiny ones ----

Shape two_cells(Numbers* n) {
  Shape s = single(n);
  s.points.push_back({1, 1, 1});
  s.tets.push_back({1, 2, 3, 4});
  wind(&s);
  return s;
}
// One vertex inside.
Shape star(Numbers* n) {
  Shape s{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, 0}}, {}};
  for (double& c : s.points[6]) c = n->between(-0.2, 0.2);
  for (const std::int64_t x : {0, 3}) {
    for (const std::int64_t y : {1, 4}) {
      for (const std::int64_t z : {2, 5}) s.tets.push_back({x, y, z, 6});
    }
  }
  wind(&s);
  return s;
}
// Cells round one edge.
Shape fan(Numbers* n) {
  Shape s{{{0, 0, -1}, {0, 0, 1}}, {}};
  const std::int64_t ring = 3 + static_cast<std::int64_t>(n->below(40));
  for (std::int64_t i = 0; i < ring; ++i) {
    const double a = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(ring);
    s.points.push_back({std::cos(a), std::sin(a), n->between(-0.1, 0.1)});
    s.tets.push_back({0, 1, 2 + i, 2 + (i + 1) % ring});
  }
  wind(&s);
  return s;
}

}  // namespace

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = [] {
    std::vector<Kind> all{{"Delaunay, ball", delaunay_ball},
                          {"Delaunay, clusters", delaunay_clusters},
                          {"Delaunay, slivers", delaunay_slivers},
                          {"Delaunay, sphere", delaunay_sphere},
                          {"Delaunay, thin sheet", delaunay_sheet},
                          {"lattice, five", five},
                          {"lattice, Kuhn", kuhn},
                          {"lattice, bcc", bcc},
                          {"lattice, coarse", coarse},
                          {"plate of one layer", plate},
                          {"beam", beam},
                          {"boundary layers", layers},
                          {"bent beam", bent},
                          {"torus", torus},
                          {"cavity", cavity},
                          {"sponge", sponge},
                          {"nested shells", nested_shells},
                          {"many parts", many_parts},
                          {"touching, not joined", unwelded},
                          {"joined at a vertex", two_at_a_vertex},
                          {"joined at an edge", two_at_an_edge},
                          {"pinched chain", pinched_chain},
                          {"crack", crack},
                          {"single cell", single},
                          {"two cells", two_cells},
                          {"star", star},
                          {"cells round an edge", fan}};
    for (const Kind& kind : broken_kinds()) all.push_back(kind);
    return all;
  }();
  return kKinds;
}

}  // namespace corpus
