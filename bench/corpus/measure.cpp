#include "measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

namespace corpus {

namespace {

using Long = long double;
using LongPoint = std::array<Long, 3>;

LongPoint long_minus(const Point& a, const Point& b) {
  return {static_cast<Long>(a[0]) - b[0], static_cast<Long>(a[1]) - b[1],
          static_cast<Long>(a[2]) - b[2]};
}
Long determinant(const LongPoint& u, const LongPoint& v, const LongPoint& w) {
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] +
         (u[0] * v[1] - u[1] * v[0]) * w[2];
}
Long length(const LongPoint& u) { return std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]); }

std::vector<Point> scaled(const std::vector<Point>& points, double unit) {
  std::vector<Point> result = points;
  for (Point& p : result) {
    for (double& c : p) c /= unit;
  }
  return result;
}

template <class... Parts>
void add(std::vector<std::string>* faults, const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  faults->push_back(text.str());
}

}  // namespace

struct Measure::Corners {
  Point a, b, c, d;
  Corners(const std::vector<Point>& points, const Tet& t)
      : a(points[static_cast<std::size_t>(t[0])]),
        b(points[static_cast<std::size_t>(t[1])]),
        c(points[static_cast<std::size_t>(t[2])]),
        d(points[static_cast<std::size_t>(t[3])]) {}
  Long volume() const {
    return std::abs(determinant(long_minus(b, a), long_minus(c, a), long_minus(d, a))) / 6;
  }
  Long error_of_volume() const;
};

// When it is computed in double precision, at most: as the program does.
Long Measure::Corners::error_of_volume() const {
  Long product = 1;
  for (const Point& p : {b, c, d}) {
    const LongPoint u = long_minus(p, a);
    product *= std::max({std::abs(u[0]), std::abs(u[1]), std::abs(u[2])});
  }
  return 43 * 0x1p-53L * product / 6;
}

Measure::Measure(const Case& c, const Mesh& result)
    : o_(c.options), before_(c.mesh), after_(result) {
  const double unit = std::max(unit_of(before_.points.data(), before_.points.size()),
                               unit_of(after_.points.data(), after_.points.size()));
  points_before_ = scaled(before_.points, unit);
  points_after_ = scaled(after_.points, unit);
  Point low{}, high{};
  bool first = true;
  std::set<Tet> seen;
  for (Tet t : before_.tets) {
    for (const std::int64_t v : t) {
      const Point& p = points_before_[static_cast<std::size_t>(v)];
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = first ? p[i] : std::min(low[i], p[i]);
        high[i] = first ? p[i] : std::max(high[i], p[i]);
        largest_ = std::max(largest_, std::abs(p[i]));
      }
      first = false;
      used_.insert(static_cast<std::size_t>(v));
    }
    std::sort(t.begin(), t.end());
    overlaps_ = overlaps_ || !seen.insert(t).second;
  }
  for (const auto& [face, cells] : faces_of(after_.tets)) {
    if (cells.size() == 1) boundary_after_.push_back(face);
  }
  diagonal_ = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  const Faces faces = faces_of(before_.tets);
  overlaps_ =
      overlaps_ || foldovers(before_, faces) > 0 ||
      std::any_of(faces.begin(), faces.end(), [](const auto& f) { return f.second.size() > 2; });
}

int Measure::sign(const Tet& t) const {
  const Corners c(points_after_, t);
  return orientation(c.a, c.b, c.c, c.d);
}

std::size_t Measure::foldovers(const Mesh& mesh, const Faces& faces) const {
  const std::vector<Point>& points = &mesh == &before_ ? points_before_ : points_after_;
  std::size_t count = 0;
  for (const auto& [face, cells] : faces) {
    if (cells.size() != 2) continue;
    std::array<int, 2> sides{};
    for (std::size_t i = 0; i < 2; ++i) {
      for (const std::int64_t v : mesh.tets[cells[i]]) {
        if (std::find(face.begin(), face.end(), v) != face.end()) continue;
        const Corners c(points, {face[0], face[1], face[2], v});
        sides[i] = orientation(c.a, c.b, c.c, c.d);
      }
    }
    count += sides[0] != 0 && sides[0] == sides[1] ? 1 : 0;
  }
  return count;
}

Triangles Measure::triangles(const std::vector<Point>& points,
                             const std::vector<Face>& faces) const {
  Triangles result;
  for (const Face& f : faces) {
    result.push_back({points[static_cast<std::size_t>(f[0])],
                      points[static_cast<std::size_t>(f[1])],
                      points[static_cast<std::size_t>(f[2])]});
  }
  return result;
}

double Measure::distance(const std::vector<Face>& before, const std::vector<Face>& after) const {
  const Triangles a = triangles(points_before_, before), b = triangles(points_after_, after);
  const double most = std::max(farthest(a, b), farthest(b, a));
  return diagonal_ > 0 ? most / diagonal_ : most;
}

double Measure::rounding() const {
  return diagonal_ > 0 ? 8 * (before_.floats ? 0x1p-23 : 0x1p-52) * largest_ / diagonal_ : 0;
}

bool Measure::finite(const Array& array, std::size_t row) {
  if (!array.is_float()) return true;
  for (std::size_t k = 0; k < array.components; ++k) {
    if (!std::isfinite(array.value(row * array.components + k))) return false;
  }
  return true;
}

std::vector<std::string> Measure::judge() const {
  std::vector<std::string> faults;
  if (o_.surface == Surface::kExact) judge_volume(&faults);
  if (overlaps_) return faults;  // nobody can say there which cell a point lies in
  judge_errors(&faults);
  if (o_.conserve) judge_integrals(&faults);
  return faults;
}

Long Measure::volume_error() const {
  Long error = 0;
  for (const Tet& t : before_.tets) error += Corners(points_before_, t).error_of_volume();
  for (const Tet& t : after_.tets) error += Corners(points_after_, t).error_of_volume();
  return error;
}

Long Measure::change_of_volume() const {
  Long change = 0;
  for (const Tet& t : after_.tets) change += Corners(points_after_, t).volume();
  for (const Tet& t : before_.tets) change -= Corners(points_before_, t).volume();
  return change;
}

void Measure::judge_volume(std::vector<std::string>* faults) const {
  const Long change = change_of_volume();
  if (!(std::abs(change) <= volume_error())) {
    add(faults, "volume: changed by ", static_cast<double>(change));
  }
}

Measure::Range Measure::range_of(const Array& array) const {
  Range range;
  for (std::size_t k = 0; k < array.components; ++k) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::size_t v : used_) {
      if (!finite(array, v)) continue;
      low = std::min(low, array.value(v * array.components + k));
      high = std::max(high, array.value(v * array.components + k));
    }
    if (low > high) return {};
    range.width = std::hypot(range.width, high - low);
    range.largest = std::max({range.largest, std::abs(low), std::abs(high)});
  }
  return range;
}

// The limit is that of the first floating-point array of points, which steers.
void Measure::judge_errors(std::vector<std::string>* faults) const {
  const bool by_default = o_.fuse && !o_.tets && !o_.max_rms;
  if (!o_.fuse || (!o_.max_error && !by_default) || before_.point_arrays.empty()) return;
  const double limit = o_.max_error.value_or(0.01);
  const Array& array = before_.point_arrays[0];
  const Array& other = *find(after_.point_arrays, array.name);
  const auto [range, largest] = range_of(array);
  if (!(range > 0) || any_in_another_cell()) return;
  const double eps = array.type == "Float32" ? 0x1p-23 : 0x1p-52;
  double worst = 0, worst_outside = 0;
  for (const std::size_t v : used_) {
    if (!finite(array, v)) continue;
    bool inside = true;
    const double error = error_at(v, array, other, &inside);
    (inside ? worst : worst_outside) = std::max(inside ? worst : worst_outside, error);
  }
  const double allowed = limit * range + 4 * eps * largest + 1e-9 * limit * range;
  if (worst > allowed) add(faults, "error: ", worst / range, " of the range, more than ", limit);
  if (worst_outside > allowed) {
    add(faults, "error outside: ", worst_outside / range, " of the range, more than ", limit);
  }
}

// The length of the difference, where the result's value is between those of some of its points.
template <class Ids, class Weights>
double Measure::difference(std::size_t v, const Array& before, const Array& after, const Ids& ids,
                           const Weights& weights) const {
  double squares = 0;
  for (std::size_t k = 0; k < before.components; ++k) {
    Long value = 0;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (weights[i] == 0) continue;
      value +=
          weights[i] *
          static_cast<Long>(after.value(static_cast<std::size_t>(ids[i]) * before.components + k));
    }
    const Long d = value - before.value(v * before.components + k);
    squares += static_cast<double>(d * d);
  }
  return std::isfinite(squares) ? std::sqrt(squares) : 0;  // what is not finite spreads
}

// Where a point lies in a cell, by the weights of its corners; nothing if it is outside by more
// than what rounding may do.
std::optional<std::array<Long, 4>> Measure::weights_in(const Corners& c, const Point& p) {
  const LongPoint u = long_minus(c.b, c.a), w = long_minus(c.c, c.a), x = long_minus(c.d, c.a),
                  q = long_minus(p, c.a);
  const Long size = std::max({length(u), length(w), length(x)});
  if (length(q) > 1.001L * size) return {};
  const Long det = determinant(u, w, x);
  if (det == 0) return {};
  std::array<Long, 4> weights{0, determinant(q, w, x) / det, determinant(u, q, x) / det,
                              determinant(u, w, q) / det};
  weights[0] = 1 - weights[1] - weights[2] - weights[3];
  const Long slack = 1e-12L + 1e-15L * size * size * size / std::abs(det);
  if (*std::min_element(weights.begin(), weights.end()) < -slack) return {};
  return weights;
}

// Does a point of the input lie inside a cell that it is no corner of?
bool Measure::any_in_another_cell() const {
  return std::any_of(before_.tets.begin(), before_.tets.end(), [&](const Tet& t) {
    const Corners corners(points_before_, t);
    return std::any_of(used_.begin(), used_.end(), [&](std::size_t v) {
      if (std::find(t.begin(), t.end(), static_cast<std::int64_t>(v)) != t.end()) return false;
      const auto weights = weights_in(corners, points_before_[v]);
      return weights && *std::min_element(weights->begin(), weights->end()) > 1e-6L;
    });
  });
}

// The least error over all points that lie there and all cells that hold the point; where rounding
// alone has it in one, at the nearest place of the boundary, too.
double Measure::error_at(std::size_t v, const Array& before, const Array& after,
                         bool* inside) const {
  const Point& p = points_before_[v];
  double best = std::numeric_limits<double>::infinity();
  const std::array<Long, 1> whole{1};
  for (std::size_t i = 0; i < points_after_.size(); ++i) {
    if (points_after_[i] != p) continue;
    best = std::min(best, difference(v, before, after, std::array{i}, whole));
  }
  constexpr Long kRounding = 1e-9L;
  bool is_sure = std::isfinite(best);
  for (const Tet& t : after_.tets) {
    const auto weights = weights_in(Corners(points_after_, t), p);
    if (!weights) continue;
    best = std::min(best, difference(v, before, after, t, *weights));
    is_sure = is_sure || *std::min_element(weights->begin(), weights->end()) > -kRounding;
  }
  *inside = std::isfinite(best);
  return is_sure ? best : std::min(best, error_outside(v, before, after));
}

// At the nearest place on the result's boundary.
double Measure::error_outside(std::size_t v, const Array& before, const Array& after) const {
  Nearest best{std::numeric_limits<double>::infinity(), {}};
  const Face* at = nullptr;
  for (const Face& f : boundary_after_) {
    const Nearest found = nearest_on(points_before_[v], triangles(points_after_, {f})[0]);
    if (found.distance >= best.distance) continue;
    best = found;
    at = &f;
  }
  return at == nullptr ? 0 : difference(v, before, after, *at, best.weights);
}

// What a unit in the last place of the coordinates is to the volume, all over the boundary.
Long Measure::rounding_of_surface() const {
  double largest = 0;
  for (const Point& p : points_before_) {
    for (const double x : p) largest = std::max(largest, std::abs(x));
  }
  Long area = 0;
  for (const auto& t : triangles(points_after_, boundary_after_)) {
    std::array<Long, 3> a{}, b{};
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] = Long{t[1][k]} - t[0][k];
      b[k] = Long{t[2][k]} - t[0][k];
    }
    area += std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]) /
            2;
  }
  const double step = before_.floats ? std::numeric_limits<float>::epsilon()
                                     : std::numeric_limits<double>::epsilon();
  return area * step * largest;
}

void Measure::judge_integrals(std::vector<std::string>* faults) const {
  // Where the boundary moves, if only by rounding, the volume changes; in some places by more than
  // in all, as it shrinks here and grows there.
  const Long error =
      volume_error() +
      (o_.surface == Surface::kExact ? 0 : std::abs(change_of_volume()) + rounding_of_surface());
  const auto judge_array = [&](const Array& before, const Array& after, bool cells) {
    if (!before.is_float()) return;
    for (std::size_t i = 0; i < before.rows(); ++i) {
      if (!finite(before, i)) return;
    }
    for (std::size_t k = 0; k < before.components; ++k) {
      Long sums[2] = {0, 0}, whole = 0;
      double largest = 0;
      const auto sum = [&](const Mesh& mesh, const std::vector<Point>& points, const Array& a,
                           Long* out) {
        for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
          Long mean = 0, size = 0;
          for (const std::int64_t v : mesh.tets[t]) {
            const double value =
                a.value((cells ? t : static_cast<std::size_t>(v)) * a.components + k);
            mean += value / 4.0L;
            size += std::abs(value) / 4.0L;
            largest = std::max(largest, std::abs(value));
          }
          const Long volume = Corners(points, mesh.tets[t]).volume();
          *out += mean * volume;
          if (&a == &before) whole += size * volume;
        }
      };
      sum(before_, points_before_, before, &sums[0]);
      sum(after_, points_after_, after, &sums[1]);
      const Long share = before.type == "Float32" ? 1e-6L : 1e-12L;
      const Long change = std::abs(sums[1] - sums[0]);
      if (change <= share * whole + error * largest) continue;
      add(faults, "integral: that of ", before.name, " has changed by ",
          static_cast<double>(change / whole), " of that of its absolute value");
    }
  };
  for (const Array& a : before_.point_arrays)
    judge_array(a, *find(after_.point_arrays, a.name), false);
  for (const Array& a : before_.cell_arrays)
    judge_array(a, *find(after_.cell_arrays, a.name), true);
}

}  // namespace corpus
