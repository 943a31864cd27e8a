#include "compare/triangles.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "base/blocks.h"
#include "base/sums.h"
#include "compare/hilbert_curve.h"
#include "compare/point_table.h"
#include "compare/sorted_by_key.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTrianglesPerBlock = 2048;

// The corners are given relative to the point.
using Triangle3 = std::array<Point, 3>;

NearestOnTriangle weigh(const Triangle3& corners, const std::array<double, 3>& weights) {
  const Point q = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
  return {weights, dot(q, q)};
}

NearestOnTriangle nearest_on_edges(const Triangle3& corners) {
  NearestOnTriangle best{{}, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Point edge = corners[j] - corners[i];
    const double squared = dot(edge, edge);
    const double along = squared > 0 ? std::clamp(-dot(corners[i], edge) / squared, 0.0, 1.0) : 0;
    std::array<double, 3> weights{};
    weights[i] = 1 - along;
    weights[j] = along;
    const NearestOnTriangle found = weigh(corners, weights);
    if (found.squared < best.squared) best = found;
  }
  return best;
}

}  // namespace

NearestOnTriangle nearest_on_triangle(const Point& p, const std::array<Point, 3>& corners) {
  // Of a triangle so flat the normal is rounding.
  constexpr double kFlat = 1e-26;
  const Triangle3 around{corners[0] - p, corners[1] - p, corners[2] - p};
  const Point one = around[1] - around[0], other = around[2] - around[0];
  const Point normal = cross(one, other);
  const double squared = dot(normal, normal);
  if (squared > kFlat * dot(one, one) * dot(other, other)) {
    const double w0 = dot(normal, cross(around[1], around[2])) / squared;
    const double w1 = dot(normal, cross(around[2], around[0])) / squared;
    const double w2 = 1 - w0 - w1;
    if (w0 >= 0 && w1 >= 0 && w2 >= 0) return weigh(around, {w0, w1, w2});
  }
  return nearest_on_edges(around);
}

Vector<std::uint32_t> order_triangles(TriangleSet* set) {
  const HilbertCurve curve(box_of(set->points));
  Vector<std::uint32_t> keys(set->triangles.size());
  for_each_block(keys.size(), kTrianglesPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t t = begin; t < end; ++t) {
                     const auto [a, b, c] = set->corners(t);
                     keys[t] = curve.key((1.0 / 3) * (a + b + c));
                   }
                 });
  Vector<std::uint32_t> order = sorted_by_key(keys, curve.key_bits());
  Vector<std::array<std::uint32_t, 3>> triangles(order.size());
  for (std::size_t t = 0; t < order.size(); ++t) triangles[t] = set->triangles[order[t]];
  set->triangles.swap(triangles);
  return order;
}

TriangleFinder::TriangleFinder(const TriangleSet* set) : set_(*set) {
  PointBox all;
  for (const Point& p : set->points) all.add(p);
  tree_.build(set->triangles.size(), all.centre(), [&](std::size_t t) {
    PointBox box;
    for (const Point& p : set->corners(t)) box.add(p);
    return box;
  });
}

TriangleFinder::Found TriangleFinder::nearest(const Point& p, std::uint32_t hint,
                                              std::uint32_t part) const {
  Found best{hint, nearest_if(p, hint, part)};
  double squared = best.nearest.squared;
  tree_.find_nearest(p, &squared, [&](std::uint32_t t) {
    const NearestOnTriangle found = nearest_if(p, t, part);
    if (found.squared < best.nearest.squared) best = {t, found};
    return found.squared;
  });
  const bool has_any = std::isfinite(best.nearest.squared) || part == kAnyPart;
  return has_any ? best : nearest(p, hint);
}

NearestOnTriangle TriangleFinder::nearest_if(const Point& p, std::uint32_t triangle,
                                             std::uint32_t part) const {
  if (part != kAnyPart && !set_.parts.empty() && set_.part_of(triangle) != part) {
    return {{}, std::numeric_limits<double>::infinity()};
  }
  return nearest_on_triangle(p, set_.corners(triangle));
}

namespace {

// Calls measure(item, &hint) for all items, by blocks.
template <class F>
Vector<double> distances(std::size_t items, F measure) {
  Vector<double> result(items);
  for_each_block(items, kTrianglesPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::uint32_t hint = 0;
    for (std::size_t i = begin; i < end; ++i) result[i] = measure(i, &hint);
  });
  return result;
}

OneSidedDistance measure_one_side(const TriangleSet& from, const TriangleFinder& to) {
  const auto distance = [&](const Point& p, std::uint32_t* hint, std::uint32_t part) {
    const TriangleFinder::Found found = to.nearest(p, *hint, part);
    *hint = found.triangle;
    return std::sqrt(found.nearest.squared);
  };
  const Vector<double> of_points =
      distances(from.points.size(), [&](std::size_t i, std::uint32_t* hint) {
        return distance(from.points[i], hint, from.part_of_point(i));
      });
  const Vector<double> of_centres =
      distances(from.triangles.size(), [&](std::size_t t, std::uint32_t* hint) {
        const auto [a, b, c] = from.corners(t);
        return distance((1.0 / 3) * (a + b + c), hint, from.part_of(t));
      });
  OneSidedDistance result;
  const auto note = [&](double d, const Point& at) {
    if (d > result.max) result.max_at = at;
    result.max = std::max(result.max, d);
  };
  for (std::size_t i = 0; i < of_points.size(); ++i) note(of_points[i], from.points[i]);
  CompensatedSum sum, area;
  for (std::size_t t = 0; t < from.triangles.size(); ++t) {
    const auto [a, b, c] = from.corners(t);
    const double weight = length(cross(b - a, c - a));
    const auto& ids = from.triangles[t];
    const double at_corners = of_points[ids[0]] + of_points[ids[1]] + of_points[ids[2]];
    note(of_centres[t], (1.0 / 3) * (a + b + c));
    // Exact for quadratic functions.
    sum.add(weight * (0.75 * of_centres[t] + at_corners / 12));
    area.add(weight);
  }
  result.area = area.value() / 2;
  result.mean = area.value() > 0 ? sum.value() / area.value() : 0;
  return result;
}

// Numbers for all points of both sets, the same for the same coordinates.
std::array<Vector<std::uint32_t>, 2> number_points(const TriangleSet& first,
                                                   const TriangleSet& second) {
  Vector<Point> all(first.points);
  all.insert(all.end(), second.points.begin(), second.points.end());
  const PointTable table(all);
  std::array<Vector<std::uint32_t>, 2> numbers;
  numbers[0].resize(first.points.size());
  numbers[1].resize(second.points.size());
  for_each_block(all.size(), kTrianglesPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) {
                     const std::size_t set = i < numbers[0].size() ? 0 : 1;
                     numbers[set][i - set * numbers[0].size()] = table.first_at(all[i]);
                   }
                 });
  return numbers;
}

Vector<std::array<std::uint32_t, 3>> numbered(const TriangleSet& set,
                                              const Vector<std::uint32_t>& numbers) {
  Vector<std::array<std::uint32_t, 3>> triangles = set.triangles;
  for (auto& triangle : triangles) {
    for (std::uint32_t& id : triangle) id = numbers[id];
    std::sort(triangle.begin(), triangle.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

// The centre of a triangle that only one of them has; none if they are the same.
std::optional<Point> find_difference(const TriangleSet& first, const TriangleSet& second) {
  const auto numbers = number_points(first, second);
  Vector<std::array<std::uint32_t, 3>> a, b;
  for_each_block(2, 1, [&](std::size_t set, std::size_t, std::size_t) {
    (set == 0 ? a : b) = numbered(set == 0 ? first : second, numbers[set]);
  });
  if (a == b) return std::nullopt;
  const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  // The smaller one of the two is not in the other list, which ascends as well.
  const bool of_first = in_b == b.end() || (in_a != a.end() && *in_a < *in_b);
  const TriangleSet& set = of_first ? first : second;
  const auto& number = numbers[of_first ? 0 : 1];
  Point sum{};
  for (const std::uint32_t corner : of_first ? *in_a : *in_b) {
    const auto at = std::find(number.begin(), number.end(), corner) - number.begin();
    sum = sum + set.points[static_cast<std::size_t>(at)];
  }
  return (1.0 / 3) * sum;
}

}  // namespace

SurfaceDistance measure_surfaces(const TriangleSet& first, const TriangleSet& second) {
  SurfaceDistance result;
  const std::optional<Point> difference = find_difference(first, second);
  result.identical = !difference;
  if (result.identical) return result;
  result.differs_at = *difference;
  if (first.triangles.empty() || second.triangles.empty()) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    result.first_to_second = result.second_to_first = {kInfinity, *difference, kInfinity};
    return result;
  }
  result.first_to_second = measure_one_side(first, TriangleFinder(&second));
  result.second_to_first = measure_one_side(second, TriangleFinder(&first));
  return result;
}

}  // namespace tetfusion
