#include "support/surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mesh/faces.h"
#include "support/work_meshes.h"

namespace tetfusion::testing {

namespace {

struct Side {
  TetId tet;
  std::array<VertexId, 3> corners;
};

std::map<std::array<VertexId, 3>, std::vector<Side>> faces_of(const WorkMesh<double>& mesh) {
  std::map<std::array<VertexId, 3>, std::vector<Side>> faces;
  for (TetId t = 0; t < mesh.tets.size(); ++t) {
    for (const auto& corners : kFaceCorners) {
      const std::array<VertexId, 3> face{mesh.tets[t][corners[0]], mesh.tets[t][corners[1]],
                                         mesh.tets[t][corners[2]]};
      std::array<VertexId, 3> key = face;
      std::sort(key.begin(), key.end());
      faces[key].push_back({t, face});
    }
  }
  return faces;
}

SurfaceTriangle triangle(const WorkMesh<double>& mesh, const std::array<VertexId, 3>& face) {
  SurfaceTriangle out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3<double>& p = mesh.positions[face[i]];
    out[i] = {p.x, p.y, p.z};
  }
  return out;
}

bool passes_through(const Point3& a, const Point3& b, const SurfaceTriangle& t) {
  const auto side = [](const Point3& p, const Point3& q, const Point3& r, const Point3& x) {
    return dot(cross(minus(q, p), minus(r, p)), minus(x, p));
  };
  if (!(side(t[0], t[1], t[2], a) * side(t[0], t[1], t[2], b) < 0)) return false;
  const double first = side(a, b, t[0], t[1]);
  return first * side(a, b, t[1], t[2]) > 0 && first * side(a, b, t[2], t[0]) > 0;
}

bool cross_each_other(const SurfaceTriangle& s, const SurfaceTriangle& t) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::find(t.begin(), t.end(), s[i]) != t.end()) return false;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (passes_through(s[i], s[(i + 1) % 3], t) || passes_through(t[i], t[(i + 1) % 3], s)) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::size_t count_crossings(const std::vector<SurfaceTriangle>& surface) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    for (std::size_t k = i + 1; k < surface.size(); ++k) {
      count += cross_each_other(surface[i], surface[k]) ? 1 : 0;
    }
  }
  return count;
}

std::vector<SurfaceTriangle> surface_of(const WorkMesh<double>& mesh) {
  std::vector<SurfaceTriangle> out;
  for (const auto& [key, sides] : faces_of(mesh)) {
    if (sides.size() == 1) out.push_back(triangle(mesh, sides[0].corners));
  }
  return out;
}

std::multiset<std::set<Point3>> boundary_of(const Geometry& mesh) {
  std::multiset<std::set<Point3>> out;
  for (const SurfaceTriangle& t : surface_of(to_work_mesh(mesh))) out.insert({t[0], t[1], t[2]});
  return out;
}

std::vector<SurfaceTriangle> surface_between(const WorkMesh<double>& mesh) {
  const Column& column = mesh.cell_columns[0];
  const auto row = [&](TetId t) { return column.rows.begin() + t * column.stride(); };
  std::vector<SurfaceTriangle> out;
  for (const auto& [key, sides] : faces_of(mesh)) {
    if (sides.size() != 2) continue;
    const auto first = row(sides[0].tet);
    if (!std::equal(first, first + column.stride(), row(sides[1].tet))) {
      out.push_back(triangle(mesh, sides[0].corners));
    }
  }
  return out;
}

double distance_to(const Point3& x, const SurfaceTriangle& t) {
  const Point3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
  bool inside = true;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& a = t[i];
    const Point3& b = t[(i + 1) % 3];
    inside = inside && dot(cross(minus(b, a), minus(x, a)), n) >= 0;
    const Point3 d = minus(x, nearest_on_segment(x, a, b));
    best = std::min(best, std::sqrt(dot(d, d)));
  }
  return inside ? std::abs(dot(minus(x, t[0]), n)) / std::sqrt(dot(n, n)) : best;
}

double furthest(const std::vector<SurfaceTriangle>& from, const std::vector<SurfaceTriangle>& to) {
  constexpr int kSteps = 4;
  double most = 0;
  for (const SurfaceTriangle& t : from) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int k = 0; i + k <= kSteps; ++k) {
        const double u = static_cast<double>(i) / kSteps, v = static_cast<double>(k) / kSteps,
                     w = 1 - u - v;
        Point3 x{};
        for (std::size_t c = 0; c < 3; ++c) x[c] = w * t[0][c] + u * t[1][c] + v * t[2][c];
        double least = std::numeric_limits<double>::infinity();
        for (const SurfaceTriangle& other : to) {
          if (least <= most) break;
          least = std::min(least, distance_to(x, other));
        }
        most = std::max(most, least);
      }
    }
  }
  return most;
}

double distance_between(const std::vector<SurfaceTriangle>& a,
                        const std::vector<SurfaceTriangle>& b) {
  return std::max(furthest(a, b), furthest(b, a));
}

std::optional<double> height_of(const std::vector<SurfaceTriangle>& surface, double x, double y) {
  for (const SurfaceTriangle& t : surface) {
    const auto side = [&](std::size_t i, std::size_t k) {
      return (t[k][0] - t[i][0]) * (y - t[i][1]) - (t[k][1] - t[i][1]) * (x - t[i][0]);
    };
    const double a = side(1, 2), b = side(2, 0), c = side(0, 1);
    if ((a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0)) continue;
    return (a * t[0][2] + b * t[1][2] + c * t[2][2]) / (a + b + c);
  }
  return std::nullopt;
}

std::int64_t euler_number(const std::set<std::array<VertexId, 3>>& triangles) {
  std::set<VertexId> vertices;
  std::set<std::pair<VertexId, VertexId>> edges;
  for (const auto& t : triangles) {
    vertices.insert(t.begin(), t.end());
    edges.insert({t[0], t[1]});
    edges.insert({t[0], t[2]});
    edges.insert({t[1], t[2]});
  }
  return static_cast<std::int64_t>(vertices.size()) - static_cast<std::int64_t>(edges.size()) +
         static_cast<std::int64_t>(triangles.size());
}

}  // namespace tetfusion::testing
