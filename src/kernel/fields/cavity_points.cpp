#include "kernel/fields/cavity_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// Of a weight: this many times the cube of the longest edge, over the determinant. Three products
// of two in a row of the inverse, three of a row with an offset, and their sums.
constexpr double kRounding = 64 * 0x1p-53;
// A point that is outside by no more than this share of a tetrahedron is so by rounding.
constexpr double kOutside = 1e-8;
// Next to a sharp edge a point is so many times as far away as it is beyond a face.
constexpr double kClose = 8;

double largest(const Point3& a) {
  return std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
}

}  // namespace

template <class Real>
void CavityPoints<Real>::begin(double unit, double max_deviation, WorkMesh<Real>* mesh,
                               LiveBalls* balls) {
  mesh_ = mesh;
  width_ = mesh->steering_width;
  unit_ = unit;
  joining_ = {};
  surface_.begin(mesh, balls, unit, max_deviation);
  if (mesh->removed.first.size() != mesh->tets.size()) mesh->removed.reset(mesh->tets.size());
}

template <class Real>
void CavityPoints<Real>::set(const Joining<Real>& joining) {
  if (joining.v != joining_.v || joining.partner != joining_.partner ||
      joining.fixed != joining_.fixed) {
    collect(joining);
  }
  joining_ = joining;
  surface_.set(joining);
  make_fan(joining);
  places_.clear();
}

template <class Real>
void CavityPoints<Real>::put_first(std::uint32_t point) {
  std::rotate(points_.begin(), points_.begin() + point, points_.begin() + point + 1);
}

// The points of the cavity.
template <class Real>
void CavityPoints<Real>::collect(const Joining<Real>& joining) {
  points_.clear();
  add_vertex(joining.v);
  if (!joining.fixed) add_vertex(joining.partner);
  for (const TetId t : joining.deleted) add_list(t, 0);
  for (std::uint32_t i = 0; i < joining.affected.size(); ++i) add_list(joining.affected[i] >> 2, i);
}

template <class Real>
void CavityPoints<Real>::add_vertex(VertexId v) {
  if ((mesh_->marks[v] & kMoved) != 0) return;
  points_.push_back({mesh_->positions[v], mesh_->steering.data() + v * width_, kNoPoint, 0});
}

template <class Real>
void CavityPoints<Real>::add_list(TetId t, std::uint32_t near) {
  const RemovedPoints<Real>& removed = mesh_->removed;
  for (std::uint32_t i = removed.first[t]; i != kNoPoint; i = removed.next[i]) {
    points_.push_back({removed.positions[i], removed.values.data() + i * width_, i, near});
  }
}

template <class Real>
void CavityPoints<Real>::make_fan(const Joining<Real>& joining) {
  fan_.clear();
  affected_ = static_cast<std::uint32_t>(joining.affected.size());
  centre_ = {joining.position.x, joining.position.y, joining.position.z};
  const auto to = [&](VertexId v) -> Point3 {
    const Vec3<Real>& p = mesh_->positions[v];
    return {(p.x - centre_.x) * unit_, (p.y - centre_.y) * unit_, (p.z - centre_.z) * unit_};
  };
  for (const std::uint32_t entry : joining.affected) {
    const Tet& tet = mesh_->tets[entry >> 2];
    const auto& order = kCornerFirst[entry & 3u];
    FanTet& fan = fan_.emplace_back();
    fan.corners = {tet[order[1]], tet[order[2]], tet[order[3]]};
    fan.tet = entry >> 2;
    const Point3 a = to(fan.corners[0]), b = to(fan.corners[1]), c = to(fan.corners[2]);
    fan.rows = {cross(b, c), cross(c, a), cross(a, b)};
    const double det = dot(a, fan.rows[0]);
    for (Point3& row : fan.rows) {
      for (double& x : row) x /= det;
    }
    const double longest = std::max({largest(a), largest(b), largest(c)});
    fan.longest = longest;
    fan.rounding = kRounding * longest * longest * longest / det;
  }
}

template <class Real>
auto CavityPoints<Real>::weights_at(const FanTet& tet, const Vec3<Real>& p) const -> Weights {
  const Point3 d{(p.x - centre_.x) * unit_, (p.y - centre_.y) * unit_, (p.z - centre_.z) * unit_};
  const double b = dot(tet.rows[0], d), c = dot(tet.rows[1], d), e = dot(tet.rows[2], d);
  return {1 - (b + c + e), b, c, e};
}

// Where the point lies: in every tetrahedron that it is not certainly outside of, so that the
// bounds hold whichever of them somebody finds it in. False if nobody can tell.
template <class Real>
bool CavityPoints<Real>::locate(std::uint32_t point) {
  const Vec3<Real>& p = points_[point].position;
  const std::uint32_t n = affected_;
  const std::size_t before = places_.size();
  double greatest = -std::numeric_limits<double>::infinity();
  std::uint32_t nearest = 0;
  for (std::uint32_t i = 0, t = points_[point].near; i < n; ++i, t = t + 1 < n ? t + 1 : 0) {
    const Weights weights = weights_at(fan_[t], p);
    const double least = std::min({weights[0], weights[1], weights[2], weights[3]});
    if (least > greatest) {
      greatest = least;
      nearest = t;
    }
    if (least < -fan_[t].rounding) continue;
    add_place(point, t, weights, least);
    if (least > fan_[t].rounding) break;  // and in no other
  }
  points_[point].near = nearest;
  return places_.size() > before || find_outside(point, nearest, greatest);
}

// What `compare` takes outside is what is nearest on the surface. Where that is so near that the
// rounding of the coordinates in the file might explain it, it takes the tetrahedron at hand.
template <class Real>
bool CavityPoints<Real>::find_outside(std::uint32_t point, std::uint32_t nearest, double least) {
  const Vec3<Real>& p = points_[point].position;
  if (-least <= kOutside + fan_[nearest].rounding) {
    add_place(point, nearest, weights_at(fan_[nearest], p), least);
    return true;
  }
  const double distance = std::sqrt(surface_.find(p, &hits_));
  if (distance > kOnSurface && !surface_.settle(p, &hits_)) return false;
  if (hits_.empty()) return false;
  for (const auto& hit : hits_) add_place_on(hit, point);
  if (distance <= std::max(kOnSurface, kClose * file_rounding(p))) {
    add_place(point, nearest, weights_at(fan_[nearest], p), least);
  }
  return true;
}

// In the unit.
template <class Real>
double CavityPoints<Real>::file_rounding(const Vec3<Real>& p) const {
  const Point3 at{p.x * unit_, p.y * unit_, p.z * unit_};
  double width = 0;
  for (const FanTet& tet : fan_) width = std::max(width, tet.longest);
  return 4 * double{std::numeric_limits<Real>::epsilon()} * (largest(at) + 2 * width);
}

template <class Real>
void CavityPoints<Real>::add_place(std::uint32_t point, std::uint32_t fan_tet,
                                   const Weights& weights, double least) {
  const double off = fan_[fan_tet].rounding + std::max(-least, 0.0);
  Place& place = places_.emplace_back(Place{point, fan_tet, weights, least, off});
  double sum = 0;
  for (double& w : place.weights) {
    w = std::max(w, 0.0);
    sum += w;
  }
  for (double& w : place.weights) w /= sum;
}

// A triangle that is flat has weights that rounding can do more to.
template <class Real>
void CavityPoints<Real>::add_place_on(const typename NearSurface<Real>::Hit& hit,
                                      std::uint32_t point) {
  const auto& face = *hit.face;
  const Point3 a = minus(face.at[1], face.at[0]), b = minus(face.at[2], face.at[0]);
  const Point3 normal = cross(a, b);
  const double longest = std::max(dot(a, a), dot(b, b));
  const double off = kRounding * longest * longest / dot(normal, normal);
  const auto& w = hit.nearest.weights;
  if (face.entry == NearSurface<Real>::kUnaffected) {
    const auto fan_tet = static_cast<std::uint32_t>(fan_.size());
    fan_.push_back({{}, 0, 0, face.ids, face.tet});
    places_.push_back({point, fan_tet, {0, w[0], w[1], w[2]}, 0, off});
    return;
  }
  Place& place = places_.emplace_back(Place{point, face.entry, {}, 0, off});
  for (std::size_t c = 0, i = 0; c < 4; ++c) place.weights[c] = c == face.omitted ? 0 : w[i++];
}

// Points outside that are nearest to what is next to the cavity are that still.
template <class Real>
bool CavityPoints<Real>::spares_neighbours() {
  if (!surface_.moves()) return true;
  if (!surface_.know_neighbours()) return false;
  const RemovedPoints<Real>& removed = mesh_->removed;
  for (const TetId t : surface_.neighbours()) {
    for (std::uint32_t i = removed.first[t]; i != kNoPoint; i = removed.next[i]) {
      if (!surface_.spares(t, removed.positions[i])) return false;
    }
  }
  return true;
}

template <class Real>
void CavityPoints<Real>::apply() {
  RemovedPoints<Real>& removed = mesh_->removed;
  for (Point& point : points_) {
    if (point.id != kNoPoint) continue;
    point.id = removed.add(1, width_);
    removed.positions[point.id] = point.position;
    std::copy_n(point.values, width_, removed.values.data() + point.id * width_);
  }
  for (const TetId t : joining_.deleted) removed.first[t] = kNoPoint;
  for (const std::uint32_t entry : joining_.affected) removed.first[entry >> 2] = kNoPoint;
  for (std::size_t i = 0; i < places_.size();) {
    std::size_t home = i;
    const std::uint32_t point = places_[i].point;
    for (; i < places_.size() && places_[i].point == point; ++i) {
      if (places_[i].depth > places_[home].depth) home = i;
    }
    removed.push(fan_[places_[home].fan_tet].tet, points_[point].id);
  }
  joining_ = {};
  surface_.forget();
}

template class CavityPoints<float>;
template class CavityPoints<double>;

}  // namespace tetfusion
