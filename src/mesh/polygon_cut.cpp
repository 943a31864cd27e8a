#include "mesh/polygon_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mesh/vectors.h"

namespace tetfusion {
namespace {

// A triangle of lower quality is one of three vertices in line, but for rounding in double
// precision: other cells that have the face are cut as if it were not, so little must do.
constexpr double kFlat = 1e-24;

constexpr std::size_t kMostCorners = 64;

}  // namespace

std::span<const std::array<VertexId, 3>> PolygonCut::cut(std::span<const VertexId> ids,
                                                         std::span<const Vec3<double>> positions) {
  triangles_.clear();
  if (ids.empty()) return {};
  const bool is_simple = take(ids, positions);
  const std::size_t n = corners_.size();
  if (n == 4 && is_simple) {
    cut_quadrilateral();
  } else if (n > kMostCorners || !is_simple) {
    cut_from(0);
  } else {
    cut_best();
  }
  return triangles_;
}

// False where it comes back to a vertex.
bool PolygonCut::take(std::span<const VertexId> ids, std::span<const Vec3<double>> positions) {
  corners_.clear();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (corners_.empty() || ids[i] != corners_.back().id)
      corners_.push_back({ids[i], positions[i]});
  }
  while (corners_.size() > 1 && corners_.front().id == corners_.back().id) corners_.pop_back();
  const auto by_id = [](const Corner& a, const Corner& b) { return a.id < b.id; };
  std::rotate(corners_.begin(), std::min_element(corners_.begin(), corners_.end(), by_id),
              corners_.end());
  is_turned_ = corners_.size() > 2 && corners_.back().id < corners_[1].id;
  if (is_turned_) std::reverse(corners_.begin() + 1, corners_.end());
  normal_ = {};
  for (std::size_t i = 2; i < corners_.size(); ++i) {
    const Vec3<double> more = cross(difference(corners_[i - 1].position, corners_[0].position),
                                    difference(corners_[i].position, corners_[0].position));
    normal_ = {normal_.x + more.x, normal_.y + more.y, normal_.z + more.z};
  }
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (corners_[i].id == corners_[j].id) return false;
    }
  }
  return true;
}

// The square of twice the area over that of the longest side's square, at most 3/4; less than 0
// where the triangle is turned over.
double PolygonCut::quality(std::size_t i, std::size_t j, std::size_t k) const {
  const Vec3<double> a = difference(corners_[j].position, corners_[i].position);
  const Vec3<double> b = difference(corners_[k].position, corners_[i].position);
  const Vec3<double> c = difference(corners_[k].position, corners_[j].position);
  const Vec3<double> area = cross(a, b);
  const double longest = std::max({dot(a, a), dot(b, b), dot(c, c)});
  if (!(longest > 0)) return 0;
  const double q = dot(area, area) / (longest * longest);
  return dot(area, normal_) < 0 ? -q : q;
}

void PolygonCut::add(std::size_t i, std::size_t j, std::size_t k) {
  if (is_turned_) std::swap(j, k);
  const VertexId a = corners_[i].id, b = corners_[j].id, c = corners_[k].id;
  if (a != b && b != c && c != a) triangles_.push_back({a, b, c});
}

void PolygonCut::cut_from(std::size_t first) {
  const std::size_t n = corners_.size();
  for (std::size_t i = 1; i + 1 < n; ++i) add(first, (first + i) % n, (first + i + 1) % n);
}

void PolygonCut::cut_quadrilateral() {
  const auto worst = [&](std::size_t first) {
    return std::min(quality(first, first + 1, (first + 2) % 4),
                    quality(first, (first + 2) % 4, (first + 3) % 4));
  };
  cut_from(std::abs(worst(0)) < kFlat && worst(1) > kFlat ? 1 : 0);
}

// Of all ways to cut it the one whose worst triangle is best, by those of its parts: what lies
// between two corners is a triangle with a third one and what lies behind its other two sides.
void PolygonCut::cut_best() {
  const std::size_t n = corners_.size();
  worst_.assign(n * n, std::numeric_limits<double>::infinity());
  third_.assign(n * n, 0);
  for (std::size_t length = 2; length < n; ++length) {
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      double best = -std::numeric_limits<double>::infinity();
      third_[i * n + j] = i + 1;
      for (std::size_t k = i + 1; k < j; ++k) {
        const double q = std::min({quality(i, k, j), worst_[i * n + k], worst_[k * n + j]});
        if (!(q > best)) continue;
        best = q;
        third_[i * n + j] = k;
      }
      worst_[i * n + j] = best;
    }
  }
  open_.assign({{0, n - 1}});
  while (!open_.empty()) {
    const auto [i, j] = open_.back();
    open_.pop_back();
    if (j < i + 2) continue;
    const std::size_t k = third_[i * n + j];
    add(i, k, j);
    open_.push_back({i, k});
    open_.push_back({k, j});
  }
}

}  // namespace tetfusion
