#include "shape_tools.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace corpus {

namespace {

int sign_of(const Shape& s, const Tet& t) {
  const auto at = [&](std::size_t i) { return s.points[static_cast<std::size_t>(t[i])]; };
  return orientation(at(0), at(1), at(2), at(3));
}

// Moves all points, or those of no boundary face, by up to half of `by`; what that turns over goes
// back.
void jitter(Numbers* n, double by, Shape* shape) {
  const std::vector<Point> start = shape->points;
  for (Point& p : shape->points) {
    for (double& c : p) c += by * n->between(-0.5, 0.5);
  }
  for (bool again = true; again;) {
    again = false;
    for (const Tet& t : shape->tets) {
      if (sign_of(*shape, t) > 0) continue;
      for (const std::int64_t v : t)
        shape->points[static_cast<std::size_t>(v)] = start[static_cast<std::size_t>(v)];
      again = true;
    }
  }
}

}  // namespace

Shape lattice(const Cube& size, bool six, const KeepCube& keep) {
  Shape shape;
  const auto [nx, ny, nz] = size;
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        shape.points.push_back(
            {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      }
    }
  }
  static const std::vector<std::array<int, 4>> kFive[2] = {
      {{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}},
      {{1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}, {0, 3, 5, 6}}};
  static const std::vector<std::array<int, 4>> kSix{{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7},
                                                    {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        if (keep && !keep(i, j, k)) continue;
        for (const auto& corners : six ? kSix : kFive[(i + j + k) % 2]) {
          Tet t{};
          for (std::size_t c = 0; c < 4; ++c) {
            const int x = i + (corners[c] & 1), y = j + (corners[c] >> 1 & 1),
                      z = k + (corners[c] >> 2);
            t[c] = (static_cast<std::int64_t>(z) * (ny + 1) + y) * (nx + 1) + x;
          }
          shape.tets.push_back(t);
        }
      }
    }
  }
  shape = compact(shape);
  wind(&shape);
  return shape;
}

Shape jittered(Numbers* n, Shape shape, double most) {
  if (n->chance(0.7)) jitter(n, n->between(0, most), &shape);
  return shape;
}

Cube size_of(Numbers* n, int low, int high) {
  const auto side = [&] {
    return low + static_cast<int>(n->below(static_cast<std::size_t>(high - low + 1)));
  };
  return {side(), side(), side()};
}

Shape joined(const Shape& a, const Shape& b) {
  Shape out = a;
  const auto shift = static_cast<std::int64_t>(a.points.size());
  out.points.insert(out.points.end(), b.points.begin(), b.points.end());
  for (Tet t : b.tets) {
    for (std::int64_t& v : t) v += shift;
    out.tets.push_back(t);
  }
  return out;
}

Shape moved(Shape s, const Point& by, double scale) {
  for (Point& p : s.points) {
    for (std::size_t i = 0; i < 3; ++i) p[i] = scale * p[i] + by[i];
  }
  return s;
}

Shape welded(Shape s, const std::function<bool(const Point&)>& here) {
  std::map<Point, std::int64_t> first;
  for (Tet& t : s.tets) {
    for (std::int64_t& v : t) {
      const Point& p = s.points[static_cast<std::size_t>(v)];
      if (here(p)) v = first.try_emplace(p, v).first->second;
    }
  }
  return compact(s);
}

std::size_t nearest(const Shape& s, const Point& place) {
  const auto distance = [&](const Point& p) {
    return std::hypot(p[0] - place[0], p[1] - place[1], p[2] - place[2]);
  };
  const auto at =
      std::min_element(s.points.begin(), s.points.end(),
                       [&](const Point& a, const Point& b) { return distance(a) < distance(b); });
  return static_cast<std::size_t>(at - s.points.begin());
}

Point in_ball(Numbers* n) {
  for (;;) {
    const Point p{n->between(-1, 1), n->between(-1, 1), n->between(-1, 1)};
    if (std::hypot(p[0], p[1], p[2]) < 1) return p;
  }
}

void wind(Shape* shape) {
  for (Tet& t : shape->tets) {
    if (sign_of(*shape, t) < 0) std::swap(t[2], t[3]);
  }
}

Shape compact(const Shape& shape) {
  std::vector<std::int64_t> ids(shape.points.size(), -1);
  Shape out;
  for (const Tet& t : shape.tets) {
    for (const std::int64_t v : t) ids[static_cast<std::size_t>(v)] = 0;
  }
  for (std::size_t v = 0; v < ids.size(); ++v) {
    if (ids[v] < 0) continue;
    ids[v] = static_cast<std::int64_t>(out.points.size());
    out.points.push_back(shape.points[v]);
  }
  out.tets = shape.tets;
  for (Tet& t : out.tets) {
    for (std::int64_t& v : t) v = ids[static_cast<std::size_t>(v)];
  }
  return out;
}

}  // namespace corpus
