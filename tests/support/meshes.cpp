#include "support/meshes.h"

#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "mesh/predicates.h"

namespace tetfusion::testing {

namespace {

using Cube = std::array<VertexId, 8>;  // corner i lies at x = i & 1, y = i >> 1 & 1, z = i >> 2

void wind(const Vector<Vec3<double>>& points, Tet* tet) {
  if (determinant(points, *tet).value < 0) flip_winding(tet);
}

template <class Split>
Geometry make_box(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double jitter,
                  std::uint64_t seed, Split split) {
  Geometry mesh;
  Vector<Vec3<double>> points;
  for (std::uint32_t z = 0; z <= nz; ++z) {
    for (std::uint32_t y = 0; y <= ny; ++y) {
      for (std::uint32_t x = 0; x <= nx; ++x) {
        points.push_back({double(x), double(y), double(z)});
      }
    }
  }
  const auto id = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (z * (ny + 1) + y) * (nx + 1) + x;
  };
  for (std::uint32_t z = 0; z < nz; ++z) {
    for (std::uint32_t y = 0; y < ny; ++y) {
      for (std::uint32_t x = 0; x < nx; ++x) {
        Cube cube;
        for (std::uint32_t i = 0; i < 8; ++i)
          cube[i] = id(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));
        for (Tet t : split(cube, (x + y + z) % 2 == 1)) {
          wind(points, &t);
          mesh.tets.push_back(t);
        }
      }
    }
  }
  const auto inside = [](double x, std::uint32_t n) { return x > 0 && x < n; };
  for (std::size_t v = 0; v < points.size(); ++v) {
    Vec3<double>& p = points[v];
    if (!inside(p.x, nx) || !inside(p.y, ny) || !inside(p.z, nz)) continue;
    p.x += jitter * (2 * uniform(seed, 3 * v) - 1);
    p.y += jitter * (2 * uniform(seed, 3 * v + 1) - 1);
    p.z += jitter * (2 * uniform(seed, 3 * v + 2) - 1);
  }
  mesh.points = std::move(points);
  return mesh;
}

}  // namespace

Geometry make_mesh(std::initializer_list<Point> points, std::initializer_list<Tet> tets) {
  Geometry mesh;
  mesh.points = Vector<Vec3<double>>(points.begin(), points.end());
  mesh.tets = Vector<Tet>(tets.begin(), tets.end());
  return mesh;
}

Geometry to_float(const Geometry& mesh) {
  Geometry result = mesh;
  Vector<Vec3<float>> points;
  for (std::size_t v = 0; v < point_count(mesh.points); ++v) {
    const Point p = point(mesh, static_cast<VertexId>(v));
    points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  result.points = std::move(points);
  return result;
}

Geometry single_tet() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
}

Geometry two_tets_sharing_face() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}},
                   {{0, 1, 2, 3}, {0, 2, 1, 4}});
}

Geometry two_tets_sharing_edge() {
  return make_mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                   {{0, 2, 3, 1}, {0, 4, 5, 1}});
}

Geometry two_tets_sharing_vertex() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                   {{0, 1, 2, 3}, {0, 5, 4, 6}});
}

Geometry icosahedron_ball() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Vector<Vec3<double>> points{{0, 0, 0}};
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-g, g}) {
      points.push_back({0, s, t});
      points.push_back({s, t, 0});
      points.push_back({t, 0, s});
    }
  }
  // Edges have length 2; triangles are the triples of vertices that are pairwise that near.
  const auto near = [&](VertexId a, VertexId b) {
    const double x = points[a].x - points[b].x, y = points[a].y - points[b].y,
                 z = points[a].z - points[b].z;
    return x * x + y * y + z * z < 4.1;
  };
  Geometry mesh;
  for (VertexId a = 1; a <= 12; ++a) {
    for (VertexId b = a + 1; b <= 12; ++b) {
      for (VertexId c = b + 1; c <= 12; ++c) {
        if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
        Tet t{0, a, b, c};
        wind(points, &t);
        mesh.tets.push_back(t);
      }
    }
  }
  mesh.points = std::move(points);
  return mesh;
}

Geometry five_split_box(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double jitter,
                        std::uint64_t seed) {
  return make_box(nx, ny, nz, jitter, seed, [](const Cube& c, bool mirrored) {
    if (mirrored) {
      return std::array<Tet, 5>{{{c[1], c[2], c[4], c[7]},
                                 {c[0], c[1], c[2], c[4]},
                                 {c[3], c[1], c[2], c[7]},
                                 {c[5], c[1], c[4], c[7]},
                                 {c[6], c[2], c[4], c[7]}}};
    }
    return std::array<Tet, 5>{{{c[0], c[3], c[5], c[6]},
                               {c[1], c[0], c[3], c[5]},
                               {c[2], c[0], c[3], c[6]},
                               {c[4], c[0], c[5], c[6]},
                               {c[7], c[3], c[5], c[6]}}};
  });
}

Geometry five_split_cube(std::uint32_t n, double jitter, std::uint64_t seed) {
  return five_split_box(n, n, n, jitter, seed);
}

Geometry kuhn_box(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double jitter,
                  std::uint64_t seed) {
  return make_box(nx, ny, nz, jitter, seed, [](const Cube& c, bool) {
    std::array<Tet, 6> tets{};
    std::size_t n = 0;
    for (const std::uint32_t i : {1u, 2u, 4u}) {
      for (const std::uint32_t j : {1u, 2u, 4u}) {
        if (i != j) tets[n++] = {c[0], c[i], c[i | j], c[7]};
      }
    }
    return tets;
  });
}

Geometry corner_of_a_cube(std::uint32_t n) {
  Geometry mesh = five_split_cube(n);
  std::erase_if(mesh.tets, [&](const Tet& tet) {
    return std::any_of(tet.begin(), tet.end(), [&](VertexId v) {
      const Vec3<double> p = point(mesh, v);
      return std::max({p.x, p.y, p.z}) > n / 2;
    });
  });
  return mesh;
}

Geometry plate(std::uint32_t n) { return five_split_box(n, n, 1); }

double uniform(std::uint64_t seed, std::uint64_t index) {
  // SplitMix64's mixer (Steele, Lea, Flood 2014).
  std::uint64_t z = seed * 0xD1B54A32D192ED03u + (index + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-53;
}

void flip_winding(Tet* tet) { std::swap((*tet)[2], (*tet)[3]); }

Point point(const Geometry& mesh, VertexId v) {
  return std::visit([v](const auto& p) { return Point{p[v].x, p[v].y, p[v].z}; }, mesh.points);
}

}  // namespace tetfusion::testing
