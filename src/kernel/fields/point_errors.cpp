#include "kernel/fields/point_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// What is kept back of a bound, for the rounding of whoever evaluates the fields. Values are chosen
// to twice that, so that writing them in their type does not lead beyond it.
constexpr double kMargin = 1e-4;
// Of a weight: this many times the cube of the longest edge, over the determinant. Three products
// of two in a row of the inverse, three of a row with an offset, and their sums.
constexpr double kRounding = 64 * 0x1p-53;
// A weight that is off by so much lets the value be off by this many times the field's range.
constexpr double kCorners = 4;
// Vectors: how often all points may draw at the new vertex's values.
constexpr int kDraws = 8;
// Where the squares of its weights at points sum up to less, these do not tell what a value should
// be.
constexpr double kLeastSay = 1.0 / 64;
// A vertex is moved by no more than this share of the length of its edges, about; where this share
// of the squared errors would go, and they are more than this share of the bounds in the mean.
constexpr double kFarthest = 0.2;
constexpr double kWorthwhile = 0.01;
constexpr double kSmallError = 0.01;

// A point that is outside by no more than this share of a tetrahedron is so by rounding.
constexpr double kOutside = 1e-8;
// Next to a sharp edge a point is so many times as far away as it is beyond a face.
constexpr double kClose = 8;

double largest(const Point3& a) {
  return std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
}

constexpr double kNoBound = std::numeric_limits<double>::infinity();

// As it is read again where it was written in single precision.
double in_single(double value, int exponent) {
  return std::ldexp(double{static_cast<float>(std::ldexp(value, -exponent))}, exponent);
}

}  // namespace

template <class Real>
void PointErrors<Real>::begin(std::span<const SteeringField> fields, const PointLimits& limits,
                              WorkMesh<Real>* mesh, LiveBalls* balls) {
  mesh_ = mesh;
  width_ = mesh->steering_width;
  unit_ = limits.unit;
  fields_.clear();
  limits_.assign(width_, kNoBound);
  losses_.assign(width_, 0);
  for (const SteeringField& f : fields) {
    const double bound = f.tolerance.value_or(limits.max_error);
    if (!(bound < kNoBound)) continue;
    const double share = std::min(bound, limits.error_now);
    const bool is_float =
        f.column != kNoColumn && mesh->point_columns[f.column].type == ValueType::kFloat32;
    fields_.push_back({f.first, f.count, f.range, share * f.range, f.exponent, is_float});
    if (f.count != 1) continue;
    limits_[f.first] = share * f.range - 2 * kMargin * (share * f.range);
    losses_[f.first] = kCorners * f.range;
  }
  bounds_ = !fields_.empty();
  bounds_all_ = bounds_ && fields_.size() == fields.size();
  joining_ = {};
  if (bounds_) surface_.begin(mesh, balls, unit_, limits.max_deviation);
  if (bounds_ && mesh->removed.first.size() != mesh->tets.size()) {
    mesh->removed.reset(mesh->tets.size());
  }
}

template <class Real>
bool PointErrors<Real>::allows(const Joining<Real>& joining, std::span<const double> low,
                               std::span<const double> high, std::span<double> values) {
  if (joining.v != joining_.v || joining.partner != joining_.partner ||
      joining.fixed != joining_.fixed) {
    collect(joining);
  }
  joining_ = joining;
  surface_.set(joining);
  make_fan(joining);
  // All tetrahedra round a vertex of the surface go: nothing is left there that could hold a point.
  if (fan_.empty() && !points_.empty()) return false;
  low_.assign(low.begin(), low.end());
  high_.assign(high.begin(), high.end());
  places_.clear();
  for (std::uint32_t i = 0; i < points_.size(); ++i) {
    std::size_t place = places_.size();
    bool allowed = find_places(i);
    for (; allowed && place < places_.size(); ++place) allowed = narrow(places_[place]);
    if (allowed) continue;
    std::rotate(points_.begin(), points_.begin() + i, points_.begin() + i + 1);
    return false;
  }
  return choose(values) && spares_neighbours();
}

// The points of the cavity.
template <class Real>
void PointErrors<Real>::collect(const Joining<Real>& joining) {
  points_.clear();
  add_vertex(joining.v);
  if (!joining.fixed) add_vertex(joining.partner);
  for (const TetId t : joining.deleted) add_list(t, 0);
  for (std::uint32_t i = 0; i < joining.affected.size(); ++i) add_list(joining.affected[i] >> 2, i);
}

template <class Real>
void PointErrors<Real>::add_vertex(VertexId v) {
  if ((mesh_->marks[v] & kMoved) != 0) return;
  points_.push_back({mesh_->positions[v], mesh_->steering.data() + v * width_, kNoPoint, 0});
}

template <class Real>
void PointErrors<Real>::add_list(TetId t, std::uint32_t near) {
  const RemovedPoints<Real>& removed = mesh_->removed;
  for (std::uint32_t i = removed.first[t]; i != kNoPoint; i = removed.next[i]) {
    points_.push_back({removed.positions[i], removed.values.data() + i * width_, i, near});
  }
}

template <class Real>
void PointErrors<Real>::make_fan(const Joining<Real>& joining) {
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
auto PointErrors<Real>::weights_at(const FanTet& tet, const Vec3<Real>& p) const -> Weights {
  const Point3 d{(p.x - centre_.x) * unit_, (p.y - centre_.y) * unit_, (p.z - centre_.z) * unit_};
  const double b = dot(tet.rows[0], d), c = dot(tet.rows[1], d), e = dot(tet.rows[2], d);
  return {1 - (b + c + e), b, c, e};
}

// Where the point lies: in every tetrahedron that it is not certainly outside of, so that the
// bounds hold whichever of them somebody finds it in. False if nobody can tell.
template <class Real>
bool PointErrors<Real>::find_places(std::uint32_t point) {
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
bool PointErrors<Real>::find_outside(std::uint32_t point, std::uint32_t nearest, double least) {
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
double PointErrors<Real>::file_rounding(const Vec3<Real>& p) const {
  const Point3 at{p.x * unit_, p.y * unit_, p.z * unit_};
  double width = 0;
  for (const FanTet& tet : fan_) width = std::max(width, tet.longest);
  return 4 * double{std::numeric_limits<Real>::epsilon()} * (largest(at) + 2 * width);
}

template <class Real>
void PointErrors<Real>::add_place(std::uint32_t point, std::uint32_t fan_tet,
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
void PointErrors<Real>::add_place_on(const typename NearSurface<Real>::Hit& hit,
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
bool PointErrors<Real>::spares_neighbours() {
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

// What the error may be, less what rounding can do where the tetrahedron is flat, or the point a
// little outside.
template <class Real>
double PointErrors<Real>::limit_at(const Place& place, const Bound& bound) const {
  return bound.limit - kCorners * place.off * bound.range;
}

// With what values of the scalar fields the bounds would hold here; false if there are none.
template <class Real>
bool PointErrors<Real>::narrow(const Place& place) {
  constexpr std::size_t kMany = 4;
  std::size_t k = 0;
  for (; k + kMany <= width_; k += kMany) {
    if (!narrow_some<kMany>(place, k)) return false;
  }
  for (; k < width_; ++k) {
    if (limits_[k] < kNoBound && !narrow_some<1>(place, k)) return false;
  }
  return true;
}

// Of kAtOnce values from that one on, side by side.
template <class Real>
template <std::size_t kAtOnce>
bool PointErrors<Real>::narrow_some(const Place& place, std::size_t first) {
  const FanTet& tet = fan_[place.fan_tet];
  const double* const steering = mesh_->steering.data() + first;
  const double* const values = points_[place.point].values + first;
  std::array<double, kAtOnce> rest{}, limit;
  for (std::size_t i = 0; i < 3; ++i) {
    const double* const corner = steering + tet.corners[i] * width_;
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      rest[k] += place.weights[i + 1] * (corner[k] - values[k]);
    }
  }
  for (std::size_t k = 0; k < kAtOnce; ++k) {
    limit[k] = limits_[first + k] - place.off * losses_[first + k];
  }
  const double weight = place.weights[0];
  bool holds = true;
  if (weight > 0) {
    std::array<double, kAtOnce> low, high;
    std::copy_n(low_.begin() + static_cast<std::ptrdiff_t>(first), kAtOnce, low.begin());
    std::copy_n(high_.begin() + static_cast<std::ptrdiff_t>(first), kAtOnce, high.begin());
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      low[k] = std::max(low[k], values[k] + (-limit[k] - rest[k]) / weight);
      high[k] = std::min(high[k], values[k] + (limit[k] - rest[k]) / weight);
    }
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      holds = holds && low[k] <= high[k] && limit[k] > 0;
    }
    std::copy_n(low.begin(), kAtOnce, low_.begin() + static_cast<std::ptrdiff_t>(first));
    std::copy_n(high.begin(), kAtOnce, high_.begin() + static_cast<std::ptrdiff_t>(first));
  } else {
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const bool within = limit[k] > 0 && std::abs(rest[k]) <= limit[k];
      holds = holds && (within || !(limits_[first + k] < kNoBound));
    }
  }
  return holds;
}

template <class Real>
bool PointErrors<Real>::choose(std::span<double> values) {
  for (const Bound& bound : fields_) {
    if (bound.count > 1 && !joining_.fixed) draw(bound, values);
    for (std::size_t k = bound.first; k < bound.first + bound.count; ++k) {
      values[k] = std::clamp(values[k], low_[k], high_[k]);
      if (bound.is_float && !joining_.fixed) values[k] = in_single(values[k], bound.exponent);
    }
  }
  return holds(values);
}

// The length of the difference at a place, and its components.
template <class Real>
double PointErrors<Real>::error_at(const Place& place, const Bound& bound,
                                   std::span<const double> values, double* differences) const {
  const double* steering = mesh_->steering.data();
  const FanTet& tet = fan_[place.fan_tet];
  const double* original = points_[place.point].values;
  double square = 0;
  for (std::uint32_t i = 0; i < bound.count; ++i) {
    const std::size_t k = bound.first + i;
    double difference = place.weights[0] * (values[k] - original[k]);
    for (std::size_t c = 0; c < 3; ++c) {
      difference += place.weights[c + 1] * (steering[tet.corners[c] * width_ + k] - original[k]);
    }
    if (differences != nullptr) differences[i] = difference;
    square += difference * difference;
  }
  return std::sqrt(square);
}

// Each point draws the values to where its own bound holds; with luck all do in the end.
template <class Real>
void PointErrors<Real>::draw(const Bound& bound, std::span<double> values) {
  differences_.resize(width_);
  for (int i = 0; i < kDraws; ++i) {
    bool moved = false;
    for (const Place& place : places_) {
      const double error = error_at(place, bound, values, differences_.data());
      const double limit = limit_at(place, bound) - 2 * kMargin * bound.limit;
      if (error <= limit || !(place.weights[0] > 0)) continue;
      const double share = (error - limit) / (error * place.weights[0]);
      for (std::uint32_t c = 0; c < bound.count; ++c) {
        const std::size_t k = bound.first + c;
        values[k] = std::clamp(values[k] - share * differences_[c], low_[k], high_[k]);
      }
      moved = true;
    }
    if (!moved) return;
  }
}

template <class Real>
bool PointErrors<Real>::holds(std::span<const double> values) const {
  for (const Place& place : places_) {
    for (const Bound& bound : fields_) {
      const double limit = limit_at(place, bound) - kMargin * bound.limit;
      if (!(error_at(place, bound, values, nullptr) <= limit)) return false;
    }
  }
  return true;
}

template <class Real>
bool PointErrors<Real>::refit(VertexId v, std::span<const std::uint32_t> ball,
                              std::span<double> values) {
  joining_ = {v, v, false, mesh_->positions[v], ball, {}};
  collect(joining_);
  const bool fits = fit(values);
  surface_.forget();
  return fits && !std::equal(values.begin(), values.end(), mesh_->steering.data() + v * width_);
}

// For the vertex and the place in hand.
template <class Real>
bool PointErrors<Real>::fit(std::span<double> values) {
  surface_.set(joining_);
  make_fan(joining_);
  places_.clear();
  are_all_known_ = !points_.empty();
  for (std::uint32_t i = 0; are_all_known_ && i < points_.size(); ++i) {
    are_all_known_ = find_places(i);
  }
  if (!are_all_known_) return false;
  const double* const own = mesh_->steering.data() + joining_.v * width_;
  std::copy_n(own, width_, values.begin());
  low_.assign(own, own + width_);
  high_.assign(own, own + width_);
  for (const Bound& bound : fields_) approach(bound, values);
  return std::ranges::all_of(places_, [this](const Place& place) { return narrow(place); }) &&
         choose(values);
}

template <class Real>
std::optional<Vec3<Real>> PointErrors<Real>::wished_position() {
  if (!are_all_known_) return std::nullopt;
  PositionWish wish;
  for (const Bound& bound : fields_) {
    for (std::size_t k = bound.first; k < bound.first + bound.count; ++k) {
      wish.add(wish_of(k), 1 / (bound.limit * bound.limit));
    }
  }
  squares_ = wish.squares();
  if (!(squares_ > kSmallError * kSmallError * static_cast<double>(places_.size()))) {
    return std::nullopt;
  }
  const Point3 step = wish.step(kWorthwhile);
  if (step == Point3{}) return std::nullopt;
  double lengths = 0;
  for (std::uint32_t t = 0; t < affected_; ++t) lengths += fan_[t].longest;
  const double most = kFarthest * lengths / affected_;
  const double length = std::sqrt(dot(step, step));
  const double part = (length > most ? most / length : 1) / unit_;
  return Vec3<Real>{static_cast<Real>(centre_.x + part * step[0]),
                    static_cast<Real>(centre_.y + part * step[1]),
                    static_cast<Real>(centre_.z + part * step[2])};
}

// Of a value that steers.
template <class Real>
PositionWish::Component PointErrors<Real>::wish_of(std::size_t k) const {
  PositionWish::Component component;
  const double* const steering = mesh_->steering.data() + k;
  const double own = steering[joining_.v * width_];
  for (const Place& place : places_) {
    const FanTet& tet = fan_[place.fan_tet];
    double error = points_[place.point].values[k] - own;
    Point3 gradient{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double rise = steering[tet.corners[i] * width_] - own;
      error -= place.weights[i + 1] * rise;
      for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis] += tet.rows[i][axis] * rise;
    }
    component.add(place.weights[0], error, gradient);
  }
  return component;
}

template <class Real>
bool PointErrors<Real>::refit_at(const Vec3<Real>& position, std::span<const std::uint32_t> ball,
                                 std::span<double> values) {
  joining_.position = position;
  joining_.affected = ball;
  if (fit(values)) {
    double squares = 0;
    for (const Place& p : places_) {
      for (const Bound& bound : fields_) {
        const double error = error_at(p, bound, values, nullptr) / bound.limit;
        squares += error * error;
      }
    }
    if (squares < squares_) return true;
  }
  surface_.forget();
  return false;
}

// The least squares of a field, in the range of what its points have.
template <class Real>
void PointErrors<Real>::approach(const Bound& bound, std::span<double> values) {
  differences_.resize(width_);
  sums_.assign(bound.count, 0);
  double squares = 0;
  for (const Place& place : places_) {
    error_at(place, bound, values, differences_.data());
    const double weight = place.weights[0];
    squares += weight * weight;
    for (std::uint32_t i = 0; i < bound.count; ++i) {
      const std::size_t k = bound.first + i;
      const double original = points_[place.point].values[k];
      sums_[i] += weight * differences_[i];
      low_[k] = std::min(low_[k], original);
      high_[k] = std::max(high_[k], original);
    }
  }
  if (!(squares > kLeastSay)) return;
  for (std::uint32_t i = 0; i < bound.count; ++i) values[bound.first + i] -= sums_[i] / squares;
}

template <class Real>
double PointErrors<Real>::largest_error(std::span<const double> values) const {
  double all = 0;
  for (const Place& place : places_) {
    for (const Bound& bound : fields_) {
      const double error = error_at(place, bound, values, nullptr) / bound.range;
      all = std::max(all, (1 + kMargin) * error + kCorners * place.off);
    }
  }
  return all;
}

template <class Real>
void PointErrors<Real>::apply() {
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

template class PointErrors<float>;
template class PointErrors<double>;

}  // namespace tetfusion
