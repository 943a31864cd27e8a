#include "kernel/quadrics/vertex_quadrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "kernel/point3.h"

namespace tetfusion {

namespace {

// Squares above this are left out: sums of them must stay finite.
constexpr double kLargestSquare = 1e30;

// So many numbers, or, where their count is not known here, as many as at run time.
template <class T, std::size_t kSize, bool kKnown>
auto numbers(std::size_t size) {
  if constexpr (kKnown) {
    return std::array<T, kSize>{};
  } else {
    return std::vector<T>(size);
  }
}

// Adds the tetrahedra to their vertices' quadrics; kWidth is the number of fields, or 0 for any.
template <std::size_t kWidth, class Real>
void add_tetrahedra(const std::vector<double>& scale, double unit, WorkMesh<Real>* mesh) {
  const std::size_t width = kWidth != 0 ? kWidth : mesh->steering_width;
  // Behind a quadric lies the row's last number, which stays.
  auto own = numbers<float, quadric_size(kWidth) + 1, kWidth != 0>(quadric_size(width) + 1);
  auto gradients = numbers<float, 3 * kWidth, kWidth != 0>(3 * width);
  static_assert((quadric_size(0) + 1) % kLanes == 0);
  for (const Tet& tet : mesh->tets) {
    const Determinant det = determinant(mesh->positions, tet);
    if (!(det.value > det.error)) continue;
    const double volume = det.value * unit * unit * unit;  // six times
    const Vec3<Real>& o = mesh->positions[tet[0]];
    std::array<Point3, 3> e{};  // edges from the first corner
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3<Real>& p = mesh->positions[tet[i + 1]];
      e[i] = {(double{p.x} - o.x) * unit, (double{p.y} - o.y) * unit, (double{p.z} - o.z) * unit};
    }
    const std::array<Point3, 3> dual{cross(e[1], e[2]), cross(e[2], e[0]), cross(e[0], e[1])};
    bool finite = true;
    for (std::size_t k = 0; k < width; ++k) {
      const double first = mesh->steering[tet[0] * width + k];
      Point3 g{};
      for (std::size_t i = 0; i < 3; ++i) {
        const double rise = (mesh->steering[tet[i + 1] * width + k] - first) * scale[k] / volume;
        for (std::size_t a = 0; a < 3; ++a) g[a] += rise * dual[i][a];
      }
      for (std::size_t a = 0; a < 3; ++a) {
        gradients[3 * k + a] = static_cast<float>(g[a]);
        finite = finite & (g[a] * g[a] < kLargestSquare);  // false where it is no number
      }
    }
    if (!finite) continue;
    std::fill(own.begin(), own.end(), 0.0F);
    add_tetrahedron(static_cast<float>(volume), gradients.data(), width, own.data());
    for (const VertexId v : tet) {
      float* const row = mesh->quadrics.data() + std::size_t{v} * mesh->quadric_width;
      for (std::size_t i = 0; i < own.size(); i += kLanes) {
        Lanes sum, more;
        std::memcpy(&sum, row + i, sizeof sum);
        std::memcpy(&more, own.data() + i, sizeof more);
        sum += more;
        std::memcpy(row + i, &sum, sizeof sum);
      }
    }
  }
}

}  // namespace

template <class Real>
void begin_quadrics(std::span<const SteeringField> fields, double unit, WorkMesh<Real>* mesh) {
  const std::size_t width = mesh->steering_width;
  mesh->quadric_width = quadric_row(mesh->steering_width, mesh->has_deviations);
  mesh->deviations.assign(mesh->has_deviations ? mesh->vertex_count() : 0, 0.0F);
  mesh->quadrics.assign(mesh->vertex_count() * mesh->quadric_width, 0.0F);
  std::vector<double> scale(width);
  for (const SteeringField& f : fields) {
    for (std::uint32_t k = 0; k < f.count; ++k) scale[f.first + k] = 1 / f.range;
  }
  if (width == 1) {
    add_tetrahedra<1>(scale, unit, mesh);
  } else {
    add_tetrahedra<0>(scale, unit, mesh);
  }
}

template void begin_quadrics(std::span<const SteeringField>, double, WorkMesh<float>*);
template void begin_quadrics(std::span<const SteeringField>, double, WorkMesh<double>*);

}  // namespace tetfusion
