// The errors of a simplified mesh at points of the original that lie outside it, each against the
// nearest point of the whole surface, without any search structure.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "compare/triangles.h"
#include "support/brute_check.h"
#include "support/point_deviation.h"
#include "support/work_meshes.h"

namespace tetfusion::testing {

struct OutsideDeviation {
  std::size_t points = 0;  // that are outside
  double worst = 0;        // share of the field's range
  double furthest = 0;     // from the surface
};

inline bool is_held(const WorkMesh<double>& mesh, const Vec3<double>& p) {
  return std::any_of(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
    if (!is_near(mesh, tet, p)) return false;
    const auto w = weights_in(mesh, tet, p);
    return *std::min_element(w.begin(), w.end()) >= -1e-12;
  });
}

inline OutsideDeviation outside_deviation(const WorkMesh<double>& original,
                                          const WorkMesh<double>& mesh,
                                          const SteeringField& field) {
  OutsideDeviation out;
  const auto boundary = brute_check(to_geometry(mesh)).boundary;
  const auto at = [](const Vec3<double>& p) { return tetfusion::Point{p.x, p.y, p.z}; };
  for (std::size_t v = 0; v < original.vertex_count(); ++v) {
    if (is_held(mesh, original.positions[v])) continue;
    ++out.points;
    double nearest = std::numeric_limits<double>::infinity(), value = 0;
    for (const auto& t : boundary) {
      const auto& p = mesh.positions;
      const auto found =
          nearest_on_triangle(at(original.positions[v]), {at(p[t[0]]), at(p[t[1]]), at(p[t[2]])});
      if (!(found.squared < nearest)) continue;
      nearest = found.squared;
      value = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        value += found.weights[i] * mesh.steering[t[i] * mesh.steering_width + field.first];
      }
    }
    const double expected = original.steering[v * original.steering_width + field.first];
    out.worst = std::max(out.worst, std::abs(value - expected) / field.range);
    out.furthest = std::max(out.furthest, std::sqrt(nearest));
  }
  return out;
}

}  // namespace tetfusion::testing
