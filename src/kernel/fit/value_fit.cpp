#include "kernel/fit/value_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "kernel/fusions.h"
#include "mesh/vectors.h"

namespace tetfusion {

namespace {

// Steps towards the least squares: the first takes most of what can be had, a fourth nothing that
// could be measured. Then so many towards a largest error of this share of what it is after them:
// a smaller one would be paid for in squares (bench/README.md).
constexpr int kSteps = 3;
constexpr int kStepsBefore = 1;
constexpr int kCorrections = 8;
constexpr double kWanted = 0.7;
// Corrections aim a little further, so that they come to an end.
constexpr double kAimed = 0.98;

// Where a vertex has less weight, it has no influence: it would have to move far for a little.
constexpr double kInfluence = 1.0 / 16;
// Where points have less weight altogether, values move by a part of what these say.
constexpr double kFullWeight = 0.5;

constexpr double kNoCeiling = -1;

std::array<double, 4> all_weights(const std::array<double, 3>& last_three) {
  const auto& [b, c, d] = last_three;
  return {1 - b - c - d, b, c, d};
}

}  // namespace

template <class Real>
std::uint64_t ValueFit<Real>::memory(std::uint64_t points, std::uint64_t tets) {
  // There are four times fewer vertices than tetrahedra, but in odd meshes.
  constexpr std::uint64_t kVertexBytes = sizeof(VertexId) + 1 + sizeof(double) + sizeof(Move);
  return points * (sizeof(Place) + sizeof(std::uint32_t) + sizeof(double)) +
         tets * kVertexBytes / 4 + tets + VertexMoves<Real>::memory(tets);
}

template <class Real>
void ValueFit<Real>::begin(WorkMesh<Real>* mesh, std::span<const std::uint32_t> columns,
                           TetWalk<Real>* walk) {
  mesh_ = mesh;
  walk_ = walk;
  columns_.assign(columns.begin(), columns.end());
  may_change_.assign(mesh->vertex_count(), 0);
  vertices_.clear();
  for (VertexId v = 0; v < mesh->vertex_count(); ++v) {
    if ((mesh->marks[v] & (kMoved | kLocked | kOnInterface)) != kMoved) continue;
    may_change_[v] = 1;
    vertices_.push_back(v);
  }
  places_.clear();
  row_of_place_.clear();
  ends_.clear();
}

template <class Real>
void ValueFit<Real>::add(const PointsToFit<Real>& points, std::uint64_t first, std::uint64_t step) {
  if (vertices_.empty()) return;
  for (std::uint64_t i = first; i < points.positions.size(); i += step) {
    const Vec3<double> point = in_double(points.positions[i]);
    const bool is_here = points.starts.empty()
                             ? walk_->find(point)
                             : walk_->find_from(in_double(points.starts[i]), point);
    if (!is_here || !depends_on_new(walk_->place())) continue;
    places_.push_back(walk_->place());
    row_of_place_.push_back(static_cast<std::uint32_t>(i));
  }
  ends_.push_back(places_.size());
}

template <class Real>
bool ValueFit<Real>::depends_on_new(const Place& place) const {
  const Tet& tet = mesh_->tets[place.tet];
  const std::array<double, 4> weights = all_weights(place.weights);
  for (std::size_t k = 0; k < 4; ++k) {
    if (may_change_[tet[k]] != 0 && weights[k] > kInfluence) return true;
  }
  return false;
}

template <class Real>
void ValueFit<Real>::fit(const ReadRows& read) {
  if (places_.empty()) return;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    for_each_component(c, read, [this] { fit_values(); });
  }
}

// Steps are small, and each takes another part of what is to be had: a third is hardly worth it.
template <class Real>
void ValueFit<Real>::move(const MoveLimits& limits, const ReadRows& read,
                          const std::function<void(const TakePoints& take)>& again) {
  constexpr int kMoves = 2;
  if (places_.empty() || limits.fields.empty()) return;
  choose_movable(limits);
  for (int i = 0; i < kMoves && !movable_.empty(); ++i) {
    vertex_moves_.begin(mesh_, &walk_->balls(), movable_);
    for (const SteeringField& field : limits.fields) {
      const auto c = std::ranges::find(columns_, field.column) - columns_.begin();
      const double scale = std::ldexp(1 / field.range, field.exponent);
      for_each_component(static_cast<std::size_t>(c), read, [&] {
        approach(kStepsBefore);
        note_errors(scale * scale);
      });
    }
    changed_.assign(mesh_->tets.size(), 0);
    const std::size_t count = vertex_moves_.move(
        limits.floor, changed_.data(),
        [this](VertexId v, const PlaceInTet& place) { take_values_along(v, place); });
    if (count == 0) return;
    std::size_t piece = 0;
    again([&](const PointsToFit<Real>& points) { find_again(piece++, points); });
  }
}

// Those inside of the mesh, and of one region.
template <class Real>
void ValueFit<Real>::choose_movable(const MoveLimits& limits) {
  const auto is_inside = [&](VertexId v) {
    const auto ball = walk_->balls().of(v);
    return std::ranges::all_of(limits.labels, [&](std::uint32_t c) {
      const Column& column = mesh_->cell_columns[c];
      const auto row = [&](std::uint32_t entry) {
        return column.rows.data() + (entry >> 2) * column.stride();
      };
      return std::ranges::all_of(ball, [&](std::uint32_t entry) {
        return std::memcmp(row(entry), row(ball[0]), column.stride()) == 0;
      });
    });
  };
  movable_.clear();
  for (const VertexId v : vertices_) {
    if ((mesh_->marks[v] & kOnBoundary) == 0 && is_inside(v)) movable_.push_back(v);
  }
}

template <class Real>
void ValueFit<Real>::note_errors(double scale) {
  vertex_moves_.begin_component();
  TetId tet = kNoTet;
  Point3 gradient{};
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i].outside) continue;
    const double error = error_at(i);
    if (!std::isfinite(error)) continue;
    if (std::exchange(tet, places_[i].tet) != places_[i].tet) gradient = gradient_in(tet);
    vertex_moves_.add({tet, all_weights(places_[i].weights)}, error, gradient);
  }
  vertex_moves_.end_component(scale);
}

// Of the component in hand.
template <class Real>
Point3 ValueFit<Real>::gradient_in(TetId tet) const {
  const Tet& t = mesh_->tets[tet];
  const auto edge = [&](std::size_t k) {
    const Vec3<Real>&p = mesh_->positions[t[k]], &first = mesh_->positions[t[0]];
    return Point3{double{p.x} - first.x, double{p.y} - first.y, double{p.z} - first.z};
  };
  const Point3 u = edge(1), v = edge(2), w = edge(3);
  const Point3 vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
  const double det = dot(u, vw), first = values_[t[0]];
  const double a = (values_[t[1]] - first) / det, b = (values_[t[2]] - first) / det,
               c = (values_[t[3]] - first) / det;
  return {a * vw[0] + b * wu[0] + c * uv[0], a * vw[1] + b * wu[1] + c * uv[1],
          a * vw[2] + b * wu[2] + c * uv[2]};
}

// All columns that are fitted later: what the mesh has at the place where the vertex will be.
template <class Real>
void ValueFit<Real>::take_values_along(VertexId v, const PlaceInTet& place) {
  const Interpolation interpolation{v, mesh_->tets[place.tet], place.weights, v};
  const auto take = [&](auto* values, std::size_t width) {
    for (std::size_t k = 0; k < width; ++k) {
      const double value = interpolate(interpolation, values, width, k);
      using T = std::remove_pointer_t<decltype(values)>;
      if (std::isfinite(value)) values[v * width + k] = static_cast<T>(value);
    }
  };
  for (const std::uint32_t c : columns_) {
    Column& column = mesh_->point_columns[c];
    std::byte* const rows = column.rows.data();
    column.type == ValueType::kFloat32 ? take(reinterpret_cast<float*>(rows), column.components)
                                       : take(reinterpret_cast<double*>(rows), column.components);
  }
}

// A point that is not found stays in its tetrahedron, next to where it lies.
template <class Real>
void ValueFit<Real>::find_again(std::size_t piece, const PointsToFit<Real>& points) {
  for (std::size_t i = piece == 0 ? 0 : ends_[piece - 1]; i < ends_[piece]; ++i) {
    Place& place = places_[i];
    if (changed_[place.tet] == 0) continue;
    const Vec3<double> point = in_double(points.positions[row_of_place_[i]]);
    if (!place.outside && walk_->find_again(place.tet, point)) {
      place = walk_->place();
      continue;
    }
    const auto weights = weights_in(point, corners(mesh_->positions, mesh_->tets[place.tet]));
    std::copy(weights.begin() + 1, weights.end(), place.weights.begin());
  }
}

template <class Real>
void ValueFit<Real>::for_each_component(std::size_t c, const ReadRows& read,
                                        const std::function<void()>& use) {
  Column& column = mesh_->point_columns[columns_[c]];
  column.type == ValueType::kFloat32 ? for_each_component_of<float>(&column, c, read, use)
                                     : for_each_component_of<double>(&column, c, read, use);
}

template <class Real>
template <class T, class Use>
void ValueFit<Real>::for_each_component_of(Column* column, std::size_t c, const ReadRows& read,
                                           const Use& use) {
  const std::size_t width = column->components;
  T* const values = reinterpret_cast<T*>(column->rows.data());
  goals_.resize(places_.size());
  values_.resize(mesh_->vertex_count());
  moves_.resize(values_.size());
  for (std::size_t k = 0; k < width; ++k) {
    std::size_t piece = 0, next = 0;
    read(c, [&](const std::byte* rows) {
      const T* const originals = reinterpret_cast<const T*>(rows);
      for (; next < ends_[piece]; ++next) goals_[next] = originals[row_of_place_[next] * width + k];
      ++piece;
    });
    for (std::size_t v = 0; v < values_.size(); ++v) values_[v] = values[v * width + k];
    use();
    for (const VertexId v : vertices_) values[v * width + k] = static_cast<T>(values_[v]);
  }
}

template <class Real>
void ValueFit<Real>::fit_values() {
  approach(kSteps);
  const double bound = kWanted * sweep(std::numeric_limits<double>::infinity());  // adds nothing up
  for (int i = 0; i < kCorrections && sweep(bound) > bound; ++i) move_values(0);
}

// Towards the least squares.
template <class Real>
void ValueFit<Real>::approach(int steps) {
  find_ranges();
  for (int i = 0; i < steps; ++i) {
    sweep(kNoCeiling);
    move_values(kFullWeight);
  }
}

// Values that take part in an interpolation are within.
template <class Real>
void ValueFit<Real>::find_ranges() {
  for (const VertexId v : vertices_) moves_[v] = {values_[v], values_[v], 0, 0};
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!std::isfinite(goals_[i])) continue;
    for (const VertexId v : mesh_->tets[places_[i].tet]) {
      if (may_change_[v] == 0) continue;
      moves_[v].least = std::min(moves_[v].least, goals_[i]);
      moves_[v].most = std::max(moves_[v].most, goals_[i]);
    }
  }
}

// Differences first: a constant is off by nothing.
template <class Real>
double ValueFit<Real>::error_at(std::size_t i) const {
  const Place& place = places_[i];
  const Tet& tet = mesh_->tets[place.tet];
  const double first = values_[tet[0]];
  double value = first;
  for (std::size_t k = 0; k < 3; ++k) value += place.weights[k] * (values_[tet[k + 1]] - first);
  return goals_[i] - value;
}

// Adds up what errors beyond the bound ask of the vertices. Without one that is the mean error
// (SIRT); else the smallest moves that would bring the point by itself within the bound
// (projections on convex sets), each as loud as the others, without those outside, where the
// mesh has no value. Returns the largest error.
template <class Real>
double ValueFit<Real>::sweep(double bound) {
  for (const VertexId v : vertices_) moves_[v].sum = moves_[v].weight = 0;
  double largest = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    if (bound >= 0 && place.outside) continue;
    const double error = error_at(i);
    if (!std::isfinite(error)) continue;
    largest = std::max(largest, std::abs(error));
    if (!(std::abs(error) > bound)) continue;
    const Tet& tet = mesh_->tets[place.tet];
    std::array<double, 4> weights = all_weights(place.weights);
    double squares = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (may_change_[tet[k]] == 0 || !(weights[k] > kInfluence)) weights[k] = 0;
      squares += weights[k] * weights[k];
    }
    const double wanted =
        bound < 0 ? error : (error - std::copysign(kAimed * bound, error)) / squares;
    for (std::size_t k = 0; k < 4; ++k) {
      if (weights[k] == 0) continue;
      Move& move = moves_[tet[k]];
      move.sum += weights[k] * wanted;
      move.weight += bound < 0 ? weights[k] : 1;
    }
  }
  return largest;
}

template <class Real>
void ValueFit<Real>::move_values(double full_weight) {
  for (const VertexId v : vertices_) {
    const Move& move = moves_[v];
    if (!(move.weight > 0)) continue;
    const double value = values_[v] + move.sum / std::max(move.weight, full_weight);
    if (std::isnan(value)) continue;  // errors that large sum up to infinity, both ways
    values_[v] = std::clamp(value, move.least, move.most);
  }
}

template class ValueFit<float>;
template class ValueFit<double>;

}  // namespace tetfusion
