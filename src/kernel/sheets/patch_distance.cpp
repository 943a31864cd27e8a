#include "kernel/sheets/patch_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// Cosines of the steepest tilts: of the fan, and of what is there already.
constexpr double kSteepestNew = 0.5;
constexpr double kSteepestOld = 0.1;

// Edges that cross at a smaller angle (its sine) count as parallel. In between the two the height
// is linear then, but for this share of the length times the slopes, which is added. Rounding is
// smaller by far.
constexpr double kParallel = 1e-6;

// A point as seen along the normal, and its height.
struct Seen {
  double x, y, h;
};

// Twice the area of o, a and b, positive where they are seen counter-clockwise.
double turn(const Seen& o, const Seen& a, const Seen& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

class View {
 public:
  explicit View(const Point3& normal) : n_(normal) {
    const std::size_t least = std::abs(n_[0]) <= std::abs(n_[1])
                                  ? (std::abs(n_[0]) <= std::abs(n_[2]) ? 0 : 2)
                                  : (std::abs(n_[1]) <= std::abs(n_[2]) ? 1 : 2);
    Point3 axis{};
    axis[least] = 1;
    e1_ = cross(axis, n_);
    const double length = std::sqrt(dot(e1_, e1_));
    for (double& c : e1_) c /= length;
    e2_ = cross(n_, e1_);
  }
  Seen operator()(const Point3& p) const { return {dot(p, e1_), dot(p, e2_), dot(p, n_)}; }

 private:
  Point3 n_, e1_, e2_;
};

using SeenTriangle = std::array<Seen, 3>;

class Comparison {
 public:
  Comparison(const PatchChange& change, const Point3& normal) : change_(change), view_(normal) {}
  bool are_graphs();
  void compare();
  double least = 0, most = 0;  // height of the fan above the patch
  double margin() const { return kParallel * width_ * (old_slope_ + new_slope_); }

 private:
  bool shows_front(const std::array<Point3, 3>& corners, double steepest, double* slope,
                   std::vector<SeenTriangle>* to);
  bool winds_once() const;
  void look_at_crossings(const Seen& from, const Seen& to);
  void note(double rise) {
    least = std::min(least, rise);
    most = std::max(most, rise);
  }

  const PatchChange& change_;
  View view_;
  std::vector<SeenTriangle> old_, fan_;
  Seen apex_{};
  std::vector<Seen> chain_;
  double old_slope_ = 0, new_slope_ = 0;  // the steepest
  double width_ = 0;                      // of the patch
};

bool Comparison::shows_front(const std::array<Point3, 3>& corners, double steepest, double* slope,
                             std::vector<SeenTriangle>* to) {
  const Point3 normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
  const SeenTriangle seen{view_(corners[0]), view_(corners[1]), view_(corners[2])};
  const double area = turn(seen[0], seen[1], seen[2]);
  const double cosine = area / std::sqrt(dot(normal, normal));
  if (!(cosine > steepest)) return false;
  *slope = std::max(*slope, std::sqrt(std::max(0.0, 1 - cosine * cosine)) / cosine);
  to->push_back(seen);
  return true;
}

bool Comparison::are_graphs() {
  for (const auto& triangle : change_.triangles) {
    if (!shows_front(triangle, kSteepestOld, &old_slope_, &old_)) return false;
  }
  apex_ = view_(change_.apex);
  for (const Point3& p : change_.chain) {
    chain_.push_back(view_(p));
    width_ = std::max(width_, std::hypot(chain_.back().x - apex_.x, chain_.back().y - apex_.y));
  }
  const std::size_t n = chain_.size();
  for (std::size_t i = 0; i + (change_.closed ? 0 : 1) < n; ++i) {
    const std::array<Point3, 3> corners{change_.apex, change_.chain[i], change_.chain[(i + 1) % n]};
    if (!shows_front(corners, kSteepestNew, &new_slope_, &fan_)) return false;
  }
  return !fan_.empty() && winds_once();
}

// The chain goes round the apex less than once, or exactly once if it is closed: each edge that
// comes to the ray through the first point from the right ends a round.
bool Comparison::winds_once() const {
  const std::size_t n = chain_.size();
  int rounds = 0;
  for (std::size_t i = 1; i + (change_.closed ? 0 : 1) < n; ++i) {
    const bool last = i + 1 == n;
    const double here = turn(apex_, chain_[0], chain_[i]);
    const double next = last ? 0 : turn(apex_, chain_[0], chain_[i + 1]);
    if (here < 0 && next >= 0) ++rounds;
  }
  return rounds == (change_.closed ? 1 : 0);
}

// The height of the triangle that has the point, or is nearest to having it.
double height_at(const std::vector<SeenTriangle>& triangles, const Seen& p) {
  double best = -std::numeric_limits<double>::infinity(), height = p.h;
  for (const SeenTriangle& t : triangles) {
    const double area = turn(t[0], t[1], t[2]);
    const std::array<double, 3> w{turn(p, t[1], t[2]) / area, turn(p, t[2], t[0]) / area,
                                  turn(p, t[0], t[1]) / area};
    const double least = std::min({w[0], w[1], w[2]});
    if (least <= best) continue;
    best = least;
    height = w[0] * t[0].h + w[1] * t[1].h + w[2] * t[2].h;
  }
  return height;
}

void Comparison::look_at_crossings(const Seen& from, const Seen& to) {
  constexpr double kSlack = 1e-9;
  const double dx = to.x - from.x, dy = to.y - from.y;
  const std::size_t begin = change_.closed ? 0 : 1;
  for (std::size_t i = begin; i + begin < chain_.size(); ++i) {
    const Seen& c = chain_[i];
    const double ex = c.x - apex_.x, ey = c.y - apex_.y;
    const double sine = dx * ey - dy * ex;
    if (sine * sine <= kParallel * kParallel * (dx * dx + dy * dy) * (ex * ex + ey * ey)) continue;
    const double ox = apex_.x - from.x, oy = apex_.y - from.y;
    const double s = (ox * ey - oy * ex) / sine, t = (ox * dy - oy * dx) / sine;
    if (s < -kSlack || s > 1 + kSlack || t < -kSlack || t > 1 + kSlack) continue;
    note(apex_.h + t * (c.h - apex_.h) - (from.h + s * (to.h - from.h)));
  }
}

void Comparison::compare() {
  for (const Point3& p : change_.points) {
    const Seen seen = view_(p);
    note(height_at(fan_, seen) - seen.h);
  }
  if (change_.closed) note(apex_.h - height_at(old_, apex_));
  for (const auto& [from, to] : change_.edges) look_at_crossings(view_(from), view_(to));
}

}  // namespace

std::optional<PatchDistance> measure(const PatchChange& change) {
  PatchDistance out;
  for (const auto& t : change.triangles) {
    const Point3 area = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    for (std::size_t i = 0; i < 3; ++i) out.normal[i] += area[i];
  }
  const double length = std::sqrt(dot(out.normal, out.normal));
  if (!(length > 0)) return std::nullopt;
  for (double& c : out.normal) c /= length;
  Comparison comparison(change, out.normal);
  if (!comparison.are_graphs()) return std::nullopt;
  comparison.compare();
  out.rise = comparison.most;
  out.distance = std::max(comparison.most, -comparison.least) + comparison.margin();
  return out;
}

namespace {

// What three planes leave of a triangle. Each makes one corner more, or, where rounding tells of
// more than two edges that it cuts, half as many again.
struct Polygon {
  std::array<Point3, 9> corners{};
  std::size_t count = 0;

  // Leaves what has dot(normal, x) <= most.
  void cut(const Point3& normal, double most) {
    Polygon left;
    for (std::size_t i = 0; i < count; ++i) {
      const Point3 &here = corners[i], &next = corners[(i + 1) % count];
      const double a = dot(normal, here) - most, b = dot(normal, next) - most;
      if (a <= 0) left.corners[left.count++] = here;
      if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
        Point3& between = left.corners[left.count++];
        for (std::size_t k = 0; k < 3; ++k)
          between[k] = here[k] + a / (a - b) * (next[k] - here[k]);
      }
    }
    *this = left;
  }
};

}  // namespace

bool lies_on_side(const Triangle3& triangle, const Triangle3& other, const Point3& direction,
                  Side side, double margin) {
  std::array<Point3, 3> outward;
  std::array<double, 3> most;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3 &from = other[i], &to = other[(i + 1) % 3];
    outward[i] = cross(minus(to, from), direction);
    most[i] = dot(outward[i], from) - margin * std::sqrt(dot(outward[i], outward[i]));
    const bool is_beside = std::all_of(triangle.begin(), triangle.end(), [&](const Point3& p) {
      return dot(outward[i], p) > most[i];
    });
    if (is_beside) return true;  // nearly all are
  }
  Polygon seen;
  std::copy(triangle.begin(), triangle.end(), seen.corners.begin());
  seen.count = triangle.size();
  for (std::size_t i = 0; i < 3 && seen.count > 0; ++i) seen.cut(outward[i], most[i]);
  if (seen.count == 0) return true;
  const Point3 normal = cross(minus(other[1], other[0]), minus(other[2], other[0]));
  const double front = dot(normal, direction);
  if (!(front > 0)) return false;
  const double scale = (side == Side::kBefore ? 1 : -1) / front;
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  for (std::size_t i = 0; i < seen.count; ++i) {
    const double height = scale * dot(minus(seen.corners[i], other[0]), normal);
    least = std::min(least, height);
    sum += height;
  }
  return least >= -margin && sum > margin * static_cast<double>(seen.count);
}

Point3 nearest_on_segment(const Point3& x, const Point3& from, const Point3& to) {
  const Point3 d = minus(to, from);
  const double square = dot(d, d);
  const double t = square > 0 ? std::clamp(dot(minus(x, from), d) / square, 0.0, 1.0) : 0;
  return {from[0] + t * d[0], from[1] + t * d[1], from[2] + t * d[2]};
}

}  // namespace tetfusion
