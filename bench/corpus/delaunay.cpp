#include <algorithm>
#include <array>
#include <cstdint>
#include <map>

#include "shapes.h"

namespace corpus {

namespace {

using Face = std::array<std::int64_t, 3>;

// The corners of the face opposite to corner i; with that corner they wind like the cell.
constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{
    {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

class Inserter {
 public:
  explicit Inserter(const std::vector<Point>& points) : points_(points), given_(points.size()) {
    double most = 1;
    for (const Point& p : points) {
      for (const double c : p) most = std::max(most, 64 * std::abs(c));
    }
    for (const Point& p : std::vector<Point>{{-1, -1, -1}, {5, -1, -1}, {-1, 5, -1}, {-1, -1, 5}}) {
      points_.push_back({most * p[0], most * p[1], most * p[2]});
    }
    const auto n = static_cast<std::int64_t>(given_);
    tets_ = {{n, n + 1, n + 2, n + 3}};
  }

  Shape run() {
    for (std::int64_t p = 0; p < static_cast<std::int64_t>(given_); ++p) insert(p);
    std::erase_if(tets_, [&](const Tet& t) {
      return std::any_of(t.begin(), t.end(),
                         [&](std::int64_t v) { return v >= static_cast<std::int64_t>(given_); });
    });
    points_.resize(given_);
    if (tets_.empty()) return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
    return {points_, tets_};
  }

 private:
  const Point& at(std::int64_t v) const { return points_[static_cast<std::size_t>(v)]; }

  void insert(std::int64_t p) {
    std::vector<Tet> kept, gone;
    for (const Tet& t : tets_) {
      const bool inside = in_sphere(at(t[0]), at(t[1]), at(t[2]), at(t[3]), at(p)) > 0;
      (inside ? gone : kept).push_back(t);
    }
    // Faces with one cell of those that go.
    std::map<Face, std::pair<int, Face>> faces;
    for (const Tet& t : gone) {
      for (const auto& corners : kFaces) {
        const Face face{t[corners[0]], t[corners[1]], t[corners[2]]};
        Face key = face;
        std::sort(key.begin(), key.end());
        auto& [count, winding] = faces[key];
        ++count;
        winding = face;
      }
    }
    for (const auto& [key, entry] : faces) {
      const auto& [count, f] = entry;
      if (count != 1) continue;
      if (orientation(at(f[0]), at(f[1]), at(f[2]), at(p)) <= 0) return;
      kept.push_back({f[0], f[1], f[2], p});
    }
    if (!gone.empty()) tets_ = std::move(kept);
  }

  std::vector<Point> points_;
  std::size_t given_;
  std::vector<Tet> tets_;
};

}  // namespace

Shape delaunay(const std::vector<Point>& points) { return compact(Inserter(points).run()); }

}  // namespace corpus
