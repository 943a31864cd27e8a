#include "partition/spatial_order.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "partition/hilbert.h"

namespace tetfusion {

namespace {

struct KeyedId {
  std::uint64_t key;
  VertexId id;
};

// Least-significant-digit radix sort: stable, and linear where a comparison sort is not. Digits
// that are the same in all keys are skipped.
void sort_by_key(Vector<KeyedId>* items) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;
  Vector<KeyedId> other(items->size());
  for (int shift = 0; shift < 3 * kHilbertBits; shift += kDigitBits) {
    std::array<std::size_t, kBuckets> start{};
    for (const KeyedId& item : *items) ++start[(item.key >> shift) & (kBuckets - 1)];
    if (std::find(start.begin(), start.end(), items->size()) != start.end()) continue;
    std::size_t sum = 0;
    for (std::size_t& s : start) {
      const std::size_t count = s;
      s = sum;
      sum += count;
    }
    for (const KeyedId& item : *items) other[start[(item.key >> shift) & (kBuckets - 1)]++] = item;
    items->swap(other);
  }
}

template <class Real>
Vector<KeyedId> curve_keys(const Vector<Vec3<Real>>& points) {
  Vector<KeyedId> keys(points.size());
  if (points.empty()) return keys;
  Vec3<double> lo{points[0].x, points[0].y, points[0].z};
  Vec3<double> hi = lo;
  for (const Vec3<Real>& p : points) {
    lo = {std::min<double>(lo.x, p.x), std::min<double>(lo.y, p.y), std::min<double>(lo.z, p.z)};
    hi = {std::max<double>(hi.x, p.x), std::max<double>(hi.y, p.y), std::max<double>(hi.z, p.z)};
  }
  // One scale for all axes: cells of the curve's grid are cubes. Halved operands cannot overflow.
  const double half_extent =
      std::max({hi.x / 2 - lo.x / 2, hi.y / 2 - lo.y / 2, hi.z / 2 - lo.z / 2});
  constexpr double kLast = (1 << kHilbertBits) - 1;
  const auto cell = [&](double value, double low) {
    if (!(half_extent > 0)) return std::uint32_t{0};
    return static_cast<std::uint32_t>(
        std::clamp((value / 2 - low / 2) / half_extent * kLast, 0.0, kLast));
  };
  const auto n = static_cast<std::int64_t>(points.size());
#pragma omp parallel for schedule(static)
  for (std::int64_t i = 0; i < n; ++i) {
    const Vec3<Real>& p = points[static_cast<std::size_t>(i)];
    keys[static_cast<std::size_t>(i)] = {
        hilbert_key(cell(p.x, lo.x), cell(p.y, lo.y), cell(p.z, lo.z)), static_cast<VertexId>(i)};
  }
  return keys;
}

// values[new] becomes values[new2old[new]].
template <class T, class Id>
void permute(const Vector<Id>& new2old, Vector<T>* values) {
  Vector<T> old(new2old.size());
  old.swap(*values);
  const auto n = static_cast<std::int64_t>(new2old.size());
#pragma omp parallel for schedule(static)
  for (std::int64_t i = 0; i < n; ++i) {
    (*values)[static_cast<std::size_t>(i)] = old[new2old[static_cast<std::size_t>(i)]];
  }
}

template <class Id>
void permute_sources(const Vector<Id>& new2old, Vector<std::uint64_t>* source) {
  if (source->empty()) {
    source->assign(new2old.begin(), new2old.end());
  } else {
    permute(new2old, source);
  }
}

}  // namespace

Vector<VertexId> points_along_curve(const Points& points) {
  Vector<KeyedId> keys = std::visit([](const auto& p) { return curve_keys(p); }, points);
  sort_by_key(&keys);
  Vector<VertexId> new2old(keys.size());
  std::transform(keys.begin(), keys.end(), new2old.begin(), [](const KeyedId& k) { return k.id; });
  return new2old;
}

Vector<TetId> tets_by_first_vertex(std::span<const Tet> tets, std::size_t vertices) {
  Vector<TetId> start;
  start.assign(vertices + 1, 0);
  const auto first_vertex = [](const Tet& t) { return std::min({t[0], t[1], t[2], t[3]}); };
  for (const Tet& t : tets) ++start[first_vertex(t) + 1];
  for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
  Vector<TetId> new2old(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    new2old[start[first_vertex(tets[t])]++] = static_cast<TetId>(t);
  }
  return new2old;
}

void order_along_curve(Geometry* geometry) {
  {
    const Vector<VertexId> new2old = points_along_curve(geometry->points);
    Vector<VertexId> old2new(new2old.size());
    for (std::size_t v = 0; v < new2old.size(); ++v) old2new[new2old[v]] = static_cast<VertexId>(v);
    std::visit([&](auto& points) { permute(new2old, &points); }, geometry->points);
    permute_sources(new2old, &geometry->point_source);
    for (Tet& t : geometry->tets) {
      for (VertexId& v : t) v = old2new[v];
    }
    for (VertexId& v : geometry->lower.connectivity) v = old2new[v];
  }
  const Vector<TetId> new2old = tets_by_first_vertex(geometry->tets, point_count(geometry->points));
  permute(new2old, &geometry->tets);
  permute_sources(new2old, &geometry->tet_source);
}

}  // namespace tetfusion
