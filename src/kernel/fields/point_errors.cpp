#include "kernel/fields/point_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// What is kept back of a bound, for the rounding of whoever evaluates the fields. Values are chosen
// to twice that, so that writing them in their type does not lead beyond it.
constexpr double kMargin = 1e-4;
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
  if (bounds_) cavity_.begin(limits.unit, limits.max_deviation, mesh, balls);
}

template <class Real>
bool PointErrors<Real>::allows(const Joining<Real>& joining, std::span<const double> low,
                               std::span<const double> high, std::span<double> values) {
  cavity_.set(joining);
  // All tetrahedra round a vertex of the surface go: nothing is left there that could hold a point.
  if (cavity_.tets().empty() && !cavity_.points().empty()) return false;
  low_.assign(low.begin(), low.end());
  high_.assign(high.begin(), high.end());
  for (std::uint32_t i = 0; i < cavity_.points().size(); ++i) {
    std::size_t place = cavity_.places().size();
    bool allowed = cavity_.locate(i);
    for (; allowed && place < cavity_.places().size(); ++place) {
      allowed = narrow(cavity_.places()[place]);
    }
    if (allowed) continue;
    cavity_.put_first(i);
    return false;
  }
  return choose(values) && cavity_.spares_neighbours();
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
  const FanTet& tet = cavity_.tet(place);
  const double* const steering = mesh_->steering.data() + first;
  const double* const values = cavity_.point(place).values + first;
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
    if (bound.count > 1 && !cavity_.joining().fixed) draw(bound, values);
    for (std::size_t k = bound.first; k < bound.first + bound.count; ++k) {
      values[k] = std::clamp(values[k], low_[k], high_[k]);
      if (bound.is_float && !cavity_.joining().fixed)
        values[k] = in_single(values[k], bound.exponent);
    }
  }
  return holds(values);
}

// The length of the difference at a place, and its components.
template <class Real>
double PointErrors<Real>::error_at(const Place& place, const Bound& bound,
                                   std::span<const double> values, double* differences) const {
  const double* steering = mesh_->steering.data();
  const FanTet& tet = cavity_.tet(place);
  const double* original = cavity_.point(place).values;
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
    for (const Place& place : cavity_.places()) {
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
  for (const Place& place : cavity_.places()) {
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
  cavity_.set_anew({v, v, false, mesh_->positions[v], ball, {}});
  std::copy_n(mesh_->steering.data() + v * width_, width_, values.begin());
  const bool fits = fit(values);
  cavity_.forget_surface();
  return fits && !std::equal(values.begin(), values.end(), mesh_->steering.data() + v * width_);
}

// For the vertex and the position in hand.
template <class Real>
bool PointErrors<Real>::fit(std::span<double> values) {
  const std::size_t points = cavity_.points().size();
  are_all_known_ = points > 0;
  for (std::uint32_t i = 0; are_all_known_ && i < points; ++i) are_all_known_ = cavity_.locate(i);
  if (!are_all_known_) return false;
  low_.assign(values.begin(), values.end());
  high_ = low_;
  for (const Bound& bound : fields_) approach(bound, values);
  return std::ranges::all_of(cavity_.places(),
                             [this](const Place& place) { return narrow(place); }) &&
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
  if (!(squares_ > kSmallError * kSmallError * static_cast<double>(cavity_.places().size()))) {
    return std::nullopt;
  }
  const Point3 step = wish.step(kWorthwhile);
  if (step == Point3{}) return std::nullopt;
  double lengths = 0;
  for (const FanTet& tet : cavity_.tets()) lengths += tet.longest;
  const double most = kFarthest * lengths / static_cast<double>(cavity_.tets().size());
  const double length = std::sqrt(dot(step, step));
  const double part = (length > most ? most / length : 1) / cavity_.unit();
  const Vec3<double>& centre = cavity_.centre();
  return Vec3<Real>{static_cast<Real>(centre.x + part * step[0]),
                    static_cast<Real>(centre.y + part * step[1]),
                    static_cast<Real>(centre.z + part * step[2])};
}

// Of a value that steers.
template <class Real>
PositionWish::Component PointErrors<Real>::wish_of(std::size_t k) const {
  PositionWish::Component component;
  const double* const steering = mesh_->steering.data() + k;
  const double own = steering[cavity_.joining().v * width_];
  for (const Place& place : cavity_.places()) {
    const FanTet& tet = cavity_.tet(place);
    double error = cavity_.point(place).values[k] - own;
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
  const VertexId v = cavity_.joining().v;
  cavity_.set({v, v, false, position, ball, {}});
  if (fit(values)) {
    double squares = 0;
    for (const Place& p : cavity_.places()) {
      for (const Bound& bound : fields_) {
        const double error = error_at(p, bound, values, nullptr) / bound.limit;
        squares += error * error;
      }
    }
    if (squares < squares_) return true;
  }
  cavity_.forget_surface();
  return false;
}

// The least squares of a field, in the range of what its points have.
template <class Real>
void PointErrors<Real>::approach(const Bound& bound, std::span<double> values) {
  differences_.resize(width_);
  sums_.assign(bound.count, 0);
  double squares = 0;
  for (const Place& place : cavity_.places()) {
    error_at(place, bound, values, differences_.data());
    const double weight = place.weights[0];
    squares += weight * weight;
    for (std::uint32_t i = 0; i < bound.count; ++i) {
      const std::size_t k = bound.first + i;
      const double original = cavity_.point(place).values[k];
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
  for (const Place& place : cavity_.places()) {
    for (const Bound& bound : fields_) {
      const double error = error_at(place, bound, values, nullptr) / bound.range;
      all = std::max(all, (1 + kMargin) * error + kCorners * place.off);
    }
  }
  return all;
}

template class PointErrors<float>;
template class PointErrors<double>;

}  // namespace tetfusion
