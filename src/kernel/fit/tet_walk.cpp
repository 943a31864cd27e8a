#include "kernel/fit/tet_walk.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/point3.h"
#include "mesh/predicates.h"
#include "mesh/vectors.h"

namespace tetfusion {

namespace {

// Longer walks from one point to the next are lost: more is hardly ever needed.
constexpr int kWalkToNext = 16;
// A weight that is less negative is rounding.
constexpr double kInside = -1e-9;
// Weights that are not negative sum up to no more where a point is near a tetrahedron.
constexpr double kNearby = 1.2;

template <class Real>
Vec3<double> mean_of(const std::array<Vec3<Real>, 4>& p) {
  return {0.25 * p[0].x + 0.25 * p[1].x + 0.25 * p[2].x + 0.25 * p[3].x,
          0.25 * p[0].y + 0.25 * p[1].y + 0.25 * p[2].y + 0.25 * p[3].y,
          0.25 * p[0].z + 0.25 * p[1].z + 0.25 * p[2].z + 0.25 * p[3].z};
}

}  // namespace

template <class Real>
std::array<double, 4> weights_in(const Vec3<double>& p, const std::array<Vec3<Real>, 4>& corners) {
  std::array<Point3, 4> r;
  for (std::size_t k = 0; k < 4; ++k) {
    r[k] = {double{corners[k].x} - p.x, double{corners[k].y} - p.y, double{corners[k].z} - p.z};
  }
  const Point3 c01 = cross(r[0], r[1]), c23 = cross(r[2], r[3]);
  std::array<double, 4> weights{dot(r[1], c23), -dot(r[0], c23), dot(r[3], c01), -dot(r[2], c01)};
  const double all = weights[0] + weights[1] + weights[2] + weights[3];
  for (double& w : weights) w /= all;
  return weights;
}

template <class Real>
std::uint64_t TetWalk<Real>::memory(std::uint64_t tets) {
  return TetNeighbours::memory(tets) + StartGrid<Real>::memory(tets) + BoxTree::memory(tets);
}

template <class Real>
void TetWalk<Real>::begin(const WorkMesh<Real>& mesh) {
  mesh_ = &mesh;
  last_ = {};
  end_ = kNoTet;
  neighbours_.begin(mesh.vertex_count(), mesh.tets);
  starts_.begin(mesh);
  overlaps_.clear();
}

template <class Real>
bool TetWalk<Real>::find(const Vec3<double>& point) {
  return look_for(point) && (overlaps_.empty() || !is_in_another(point));
}

// From near the point where there are gaps on the way, or cells without volume.
template <class Real>
bool TetWalk<Real>::look_for(const Vec3<double>& point) {
  if (walk(last_.tet, kWalkToNext, point)) return true;
  const TetId start = starts_.near(point);
  if (start == kNoTet) return false;
  if (walk(start, kWalkFromStart, point)) return true;
  return starts_.any_around(
      point, [&](TetId other) { return other != start && walk(other, kWalkFromStart, point); });
}

template <class Real>
bool TetWalk<Real>::leave_out_overlaps() {
  if (!overlaps_itself()) return false;
  overlaps_.build_alone(mesh_->tets.size(), in_double(mesh_->positions[0]), [&](std::size_t t) {
    PointBox box;
    for (const VertexId v : mesh_->tets[t]) box.add(in_double(mesh_->positions[v]));
    return box;
  });
  return true;
}

// Than the one where it was found last, and those that touch it.
template <class Real>
bool TetWalk<Real>::is_in_another(const Vec3<double>& point) const {
  const Tet& own = mesh_->tets[last_.tet];
  return overlaps_.find(point, 0, [&](std::size_t t) {
    const Tet& other = mesh_->tets[t];
    if (std::ranges::find_first_of(own, other) != own.end()) return false;
    const std::array<double, 4> w = weights_in(point, corners(mesh_->positions, other));
    return std::min({w[0], w[1], w[2], w[3]}) >= kInside;
  });
}

// Walks to places in order find now the one, now the other of two parts that lie over each other.
template <class Real>
bool TetWalk<Real>::overlaps_itself() {
  constexpr std::size_t kEnough = 8192;
  constexpr double kDeep = 0.02;  // what is less deep inside touches only, as in contact
  std::vector<TetId> at_boundary;
  for (VertexId v = 0; v < mesh_->vertex_count(); ++v) {
    const auto ball = balls().of(v);
    if ((mesh_->marks[v] & kOnBoundary) == 0 || ball.empty()) continue;
    const TetId tet = ball[0] >> 2;
    if (determinant(mesh_->positions, mesh_->tets[tet]).sign() > 0) at_boundary.push_back(tet);
  }
  const std::size_t step = at_boundary.size() / kEnough + 1;
  for (std::size_t i = 0; i < at_boundary.size(); i += step) {
    const auto centre = mean_of(corners(mesh_->positions, mesh_->tets[at_boundary[i]]));
    if (!look_for(centre) || last_.tet == at_boundary[i]) continue;
    const auto& [b, c, d] = last_.weights;
    if (std::min({1 - b - c - d, b, c, d}) > kDeep) return true;
  }
  return false;
}

// A walk crosses no crack.
template <class Real>
bool TetWalk<Real>::find_from(const Vec3<double>& start, const Vec3<double>& point) {
  if (!find(start)) return false;
  const bool is_same = start.x == point.x && start.y == point.y && start.z == point.z;
  return is_same || walk(last_.tet, kWalkFromStart, point) || place_nearby(point);
}

// Of a point outside, in the tetrahedron where the walk ended.
template <class Real>
bool TetWalk<Real>::place_nearby(const Vec3<double>& point) {
  if (end_ == kNoTet) return false;
  const std::array<double, 4> w = weights_in(point, corners(mesh_->positions, mesh_->tets[end_]));
  double sum = 0;
  for (const double x : w) sum += std::max(x, 0.0);
  if (!(sum <= kNearby)) return false;
  last_ = {{w[1], w[2], w[3]}, end_, true};
  return true;
}

// Always over the face that the point is furthest beyond, if there is a tetrahedron on the other
// side and it is not where the walk comes from. Where it ends without the point, last_ stays.
template <class Real>
bool TetWalk<Real>::walk(TetId start, int longest, const Vec3<double>& point) {
  TetId t = start;
  TetId before = kNoTet;
  end_ = kNoTet;
  for (int i = 0; i < longest; ++i) {
    const std::array<double, 4> w = weights_in(point, corners(mesh_->positions, mesh_->tets[t]));
    if (std::min({w[0], w[1], w[2], w[3]}) >= kInside) {
      last_ = {{w[1], w[2], w[3]}, t};
      return true;
    }
    std::array<double, 4> left = w;
    TetId next = kNoTet;
    while (next == kNoTet || next == before) {
      const auto furthest = std::min_element(left.begin(), left.end());
      if (!(*furthest < kInside)) {
        end_ = t;
        return false;
      }
      *furthest = 0;
      next = neighbours_.beyond(t, static_cast<std::size_t>(furthest - left.begin()));
    }
    before = t;
    t = next;
  }
  return false;
}

template std::array<double, 4> weights_in(const Vec3<double>&, const std::array<Vec3<float>, 4>&);
template std::array<double, 4> weights_in(const Vec3<double>&, const std::array<Vec3<double>, 4>&);
template class TetWalk<float>;
template class TetWalk<double>;

}  // namespace tetfusion
