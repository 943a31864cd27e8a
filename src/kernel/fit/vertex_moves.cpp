#include "kernel/fit/vertex_moves.h"

#include <algorithm>
#include <cmath>

#include "kernel/criteria.h"
#include "kernel/fit/tet_walk.h"
#include "kernel/shapes/cell_shape.h"

namespace tetfusion {

namespace {

// As its neighbours move, too, it goes this part of the way, and no further than this share of the
// mean length of its edges; and not at all where this share of the squared errors would not go.
constexpr double kPart = 0.7;
constexpr double kFarthest = 0.1;
constexpr double kWorthwhile = 0.02;
// Where a shape is in the way, half of that, and again.
constexpr int kHalvings = 3;

template <class Real>
Point3 point_of(const Vec3<Real>& p) {
  return {p.x, p.y, p.z};
}

template <class Real>
double cubed_mean_ratio(const std::array<Vec3<Real>, 4>& p) {
  return shape_of(p[0], p[1], p[2], p[3], 1).cubed_mean_ratio();
}

}  // namespace

template <class Real>
std::uint64_t VertexMoves<Real>::memory(std::uint64_t tets) {
  // There are four times fewer vertices than tetrahedra, but in odd meshes.
  return tets / 4 *
         (sizeof(std::uint32_t) + sizeof(PositionWish::Component) + sizeof(PositionWish));
}

template <class Real>
void VertexMoves<Real>::begin(WorkMesh<Real>* mesh, const VertexTets* balls,
                              std::span<const VertexId> vertices) {
  mesh_ = mesh;
  balls_ = balls;
  vertices_ = vertices;
  index_.assign(mesh->vertex_count(), kNoVertex);
  for (std::uint32_t i = 0; i < vertices.size(); ++i) index_[vertices[i]] = i;
  wishes_.assign(vertices.size(), {});
}

template <class Real>
void VertexMoves<Real>::begin_component() {
  components_.assign(vertices_.size(), {});
}

template <class Real>
void VertexMoves<Real>::add(const PlaceInTet& point, double error, const Point3& gradient) {
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t i = index_[mesh_->tets[point.tet][k]];
    if (i != kNoVertex) components_[i].add(point.weights[k], error, gradient);
  }
}

template <class Real>
void VertexMoves<Real>::end_component(double scale) {
  for (std::size_t i = 0; i < wishes_.size(); ++i) wishes_[i].add(components_[i], scale);
}

// None where it would not pay.
template <class Real>
Point3 VertexMoves<Real>::step(VertexId v, const PositionWish& wish) const {
  Point3 step = wish.step(kWorthwhile);
  if (step == Point3{}) return step;
  double lengths = 0;
  std::size_t edges = 0;
  const Point3 here = point_of(mesh_->positions[v]);
  for (const std::uint32_t entry : balls_->of(v)) {
    for (const VertexId other : mesh_->tets[entry >> 2]) {
      const Point3 edge = minus(point_of(mesh_->positions[other]), here);
      lengths += std::sqrt(dot(edge, edge));
    }
    edges += 3;
  }
  const double length = std::sqrt(dot(step, step));
  const double most = kFarthest * lengths / static_cast<double>(edges);
  const double part = kPart * (length > most ? most / length : 1);
  for (double& x : step) x *= part;
  return step;
}

template <class Real>
bool VertexMoves<Real>::find_position(VertexId v, const Point3& step, double floor,
                                      Vec3<Real>* position) const {
  if (step == Point3{}) return false;
  const Vec3<Real>& here = mesh_->positions[v];
  double part = 1;
  for (int i = 0; i <= kHalvings; ++i, part /= 2) {
    *position = {static_cast<Real>(here.x + part * step[0]),
                 static_cast<Real>(here.y + part * step[1]),
                 static_cast<Real>(here.z + part * step[2])};
    if (keeps_shapes(v, *position, floor)) return true;
  }
  return false;
}

template <class Real>
bool VertexMoves<Real>::keeps_shapes(VertexId v, const Vec3<Real>& position, double floor) const {
  const double cubed = floor * floor * floor;
  for (const std::uint32_t entry : balls_->of(v)) {
    const Tet& tet = mesh_->tets[entry >> 2];
    const std::uint32_t corner = entry & 3;
    if (flips_as_written(position, corner, tet, mesh_->positions)) return false;
    const std::array<Vec3<Real>, 4> before = corners(mesh_->positions, tet);
    std::array<Vec3<Real>, 4> after = before;
    after[corner] = position;
    const double shape = cubed_mean_ratio(after);
    if (!(shape >= cubed) && !(shape >= cubed_mean_ratio(before))) return false;
  }
  return true;
}

// Where it is furthest inside.
template <class Real>
PlaceInTet VertexMoves<Real>::in_ball(VertexId v, const Vec3<Real>& position) const {
  const Vec3<double> point{position.x, position.y, position.z};
  PlaceInTet best;
  double depth = -std::numeric_limits<double>::infinity();
  for (const std::uint32_t entry : balls_->of(v)) {
    const auto weights = weights_in(point, corners(mesh_->positions, mesh_->tets[entry >> 2]));
    const double least = std::min({weights[0], weights[1], weights[2], weights[3]});
    if (!(least > depth)) continue;
    depth = least;
    best = {entry >> 2, weights};
  }
  return best;
}

template class VertexMoves<float>;
template class VertexMoves<double>;

}  // namespace tetfusion
