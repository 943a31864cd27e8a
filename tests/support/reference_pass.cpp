#include "support/reference_pass.h"

#include <algorithm>
#include <cmath>

namespace tetfusion::testing {

namespace {

using Point3 = std::array<double, 3>;
using Cell = std::array<std::uint32_t, 4>;
using Corners = std::array<Point3, 4>;

Corners corners(const std::vector<Point3>& points, const Cell& cell) {
  return {points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]};
}

long double volume(const Corners& p) {
  std::array<std::array<long double, 3>, 3> e{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      e[i][k] = static_cast<long double>(p[i + 1][k]) - static_cast<long double>(p[0][k]);
    }
  }
  return (e[0][1] * e[1][2] - e[0][2] * e[1][1]) * e[2][0] +
         (e[0][2] * e[1][0] - e[0][0] * e[1][2]) * e[2][1] +
         (e[0][0] * e[1][1] - e[0][1] * e[1][0]) * e[2][2];
}

double distance(const Point3& a, const Point3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Length of the base normal: from the centre of the base triangle to the barycenter of the
// tetrahedron.
double base_normal(const Corners& p, std::size_t corner) {
  Point3 base{};
  Point3 center{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      center[k] += p[i][k] / 4;
      if (i != corner) base[k] += p[i][k] / 3;
    }
  }
  return distance(base, center);
}

double aspect(const Corners& p) {
  double longest = 0;
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      longest = std::max(longest, distance(p[i], p[j]));
      shortest = std::min(shortest, distance(p[i], p[j]));
    }
  }
  return longest / shortest;
}

int shared_vertices(const Cell& a, const Cell& b) {
  int shared = 0;
  for (const std::uint32_t v : a) shared += static_cast<int>(std::count(b.begin(), b.end(), v));
  return shared;
}

class Pass {
 public:
  Pass(const ReferenceMesh& mesh, const ReferenceLimits& limits)
      : start_(mesh),
        limits_(limits),
        labelled_(mesh.tets.size()),
        deleted_(mesh.tets.size()),
        moved_(mesh.points.size()) {
    result_.mesh = mesh;
  }

  ReferenceResult run() {
    for (std::size_t t = 0; t < start_.tets.size(); ++t) {
      if (!labelled_[t] && !deleted_[t] && allowed(t)) fuse(t);
    }
    std::vector<Cell> kept;
    for (std::size_t t = 0; t < deleted_.size(); ++t) {
      if (!deleted_[t]) kept.push_back(result_.mesh.tets[t]);
    }
    result_.mesh.tets = kept;
    return result_;
  }

 private:
  bool is_boundary(const Cell& cell) const {
    return std::any_of(cell.begin(), cell.end(), [&](auto v) { return start_.on_boundary[v]; });
  }

  bool allowed(std::size_t t) {
    const ReferenceMesh& mesh = result_.mesh;
    const Cell prey = mesh.tets[t];
    if (is_boundary(prey)) return refuse(&result_.boundary);
    for (std::size_t u = 0; u < mesh.tets.size() && limits_.boundary_tets_stay; ++u) {
      const bool touches = !deleted_[u] && shared_vertices(mesh.tets[u], prey) > 0;
      if (touches && is_boundary(mesh.tets[u])) return refuse(&result_.boundary);
    }
    target_ = {};
    scalar_ = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      target_[k] = 0.25 * ((mesh.points[prey[0]][k] + mesh.points[prey[1]][k]) +
                           (mesh.points[prey[2]][k] + mesh.points[prey[3]][k]));
    }
    scalar_ = 0.25 * ((mesh.scalars[prey[0]] + mesh.scalars[prey[1]]) +
                      (mesh.scalars[prey[2]] + mesh.scalars[prey[3]]));
    for (const auto v : prey) {
      if (!(std::abs(mesh.scalars[v] - scalar_) < limits_.scalar_tolerance)) {
        return refuse(&result_.scalar);
      }
    }
    if (any_affected(prey, [&](auto u, auto c) { return flips(u, c); }))
      return refuse(&result_.flip);
    bool aspect_first = false;
    const bool bad = any_affected(prey, [&](auto u, auto c) {
      if (stretches(u, c)) return true;
      aspect_first = distorts(u, c);
      return aspect_first;
    });
    if (bad) return refuse(aspect_first ? &result_.aspect : &result_.stretch);
    return true;
  }

  static bool refuse(std::uint64_t* counter) {
    ++*counter;
    return false;
  }

  // In the order of the prey's corners, and of the tetrahedra round each.
  template <class Test>
  bool any_affected(const Cell& prey, Test&& test) const {
    for (const auto v : prey) {
      for (std::size_t u = 0; u < result_.mesh.tets.size(); ++u) {
        const Cell& cell = result_.mesh.tets[u];
        const auto at = std::find(cell.begin(), cell.end(), v);
        if (deleted_[u] || at == cell.end() || shared_vertices(cell, prey) != 1) continue;
        if (test(u, static_cast<std::size_t>(at - cell.begin()))) return true;
      }
    }
    return false;
  }

  Corners after(std::size_t u, std::size_t corner) const {
    Corners p = corners(result_.mesh.points, result_.mesh.tets[u]);
    p[corner] = target_;
    return p;
  }
  bool flips(std::size_t u, std::size_t corner) const {
    return !(volume(after(u, corner)) > 1e-13L);
  }
  bool stretches(std::size_t u, std::size_t corner) const {
    const Corners before = corners(start_.points, start_.tets[u]);
    for (std::size_t c = 0; c < 4; ++c) {
      if (c != corner && !moved_[result_.mesh.tets[u][c]]) continue;
      const double ratio = base_normal(after(u, corner), c) / base_normal(before, c);
      if (!(ratio < limits_.stretch_factor)) return true;
    }
    return false;
  }
  bool distorts(std::size_t u, std::size_t corner) const {
    const double ratio = aspect(after(u, corner));
    return ratio > limits_.aspect_ratio &&
           ratio > aspect(corners(result_.mesh.points, result_.mesh.tets[u]));
  }

  void fuse(std::size_t t) {
    ReferenceMesh& mesh = result_.mesh;
    const Cell prey = mesh.tets[t];
    const std::uint32_t kept = *std::min_element(prey.begin(), prey.end());
    for (std::size_t u = 0; u < mesh.tets.size(); ++u) {
      if (deleted_[u]) continue;
      const int shared = shared_vertices(mesh.tets[u], prey);
      if (shared >= 2) deleted_[u] = true;
      if (shared != 1) continue;
      labelled_[u] = true;
      for (auto& v : mesh.tets[u]) {
        if (std::count(prey.begin(), prey.end(), v) > 0) v = kept;
      }
    }
    mesh.points[kept] = target_;
    mesh.scalars[kept] = scalar_;
    moved_[kept] = true;
    ++result_.fused;
  }

  const ReferenceMesh& start_;
  const ReferenceLimits& limits_;
  std::vector<bool> labelled_, deleted_, moved_;
  Point3 target_{};
  double scalar_ = 0;
  ReferenceResult result_;
};

}  // namespace

ReferenceResult reference_pass(const ReferenceMesh& mesh, const ReferenceLimits& limits) {
  return Pass(mesh, limits).run();
}

}  // namespace tetfusion::testing
