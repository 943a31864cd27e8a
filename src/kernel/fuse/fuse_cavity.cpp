#include "kernel/fuse/fuse_cavity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernel/point3.h"
#include "kernel/shapes/cell_shape.h"

namespace tetfusion {

namespace {

// Obstacles are cleared by a little more than is needed.
constexpr double kPush = 1.05;

// A mean ratio from which on the sign of a volume is beyond doubt, in meshes of such extents: where
// volumes leave the range of double precision it is never.
constexpr double kSureQuality = 1e-3;
constexpr double kLeastExtent = 1e-76, kMostExtent = 1e96;

double cube(double x) { return x * x * x; }

}  // namespace

template <class Real>
auto FuseCavity<Real>::limit_of(double least) const -> Limit {
  const double extent = 1 / unit_;
  const double sure = extent > kLeastExtent && extent < kMostExtent
                          ? std::max(least, cube(kSureQuality))
                          : std::numeric_limits<double>::infinity();
  // With room for the rounding of these numbers.
  return {
      least,
      sure,
      {static_cast<float>(sure / 432 * (1 + 1e-5)), static_cast<float>(least / 432 * (1 - 1e-5))}};
}

template <class Real>
void FuseCavity<Real>::begin(WorkMesh<Real>* mesh, LiveBalls* balls, double min_quality,
                             double unit) {
  mesh_ = mesh;
  balls_ = balls;
  unit_ = unit;
  grades_ = ShapeGrades(min_quality);
  floor_ = limit_of(grades_.floor());
  of_vertex_.shapes.forget();
  of_partner_.shapes.forget();
  grid_.reset(mesh->positions);
  has_none_bad_.assign(mesh->vertex_count(), false);
}

// Grades spread no further than they were made use of.
template <class Real>
void FuseCavity<Real>::note_fused(VertexId kept) {
  if (grade_ > 0) {
    for (const std::uint32_t entry : affected_) {
      const Tet& tet = mesh_->tets[entry >> 2];
      const std::uint8_t grade = grades_.grade_of(cubed_mean_ratio(tet));
      std::uint16_t& own = mesh_->remembered[entry >> 2];
      own = std::max(own, std::uint16_t{std::min(grade, grade_)});
      for (const VertexId v : tet) has_none_bad_[v] = false;
    }
  } else if (!fixed_) {
    has_none_bad_[kept] = true;
  }
  of_vertex_.shapes.forget();
  of_partner_.shapes.forget();
  grid_.move(kept, mesh_->positions[kept]);
}

template <class Real>
std::optional<Reject> FuseCavity<Real>::collect(VertexId v, VertexId partner, bool fixed,
                                                const Vec3<Real>& position) {
  partner_ = partner;
  fixed_ = fixed;
  position_ = position;
  Ball& own = ball_of(v, &of_vertex_);
  grade_ = 0;
  if (!fixed && of_partner_.shapes.vertex() != partner) balls_->prefetch_tets(partner, mesh_->tets);
  if (const auto reason = judge_ball(&own, partner)) return reason;
  if (!fixed) {
    if (const auto reason = judge_ball(&ball_of(partner, &of_partner_), v)) return reason;
  }
  list();
  return std::nullopt;
}

template <class Real>
auto FuseCavity<Real>::ball_of(VertexId v, Ball* ball) -> Ball& {
  if (ball->shapes.vertex() != v) {
    ball->shapes.begin(*mesh_, grid_, v, balls_->of(v, mesh_->incidence[v], mesh_->tets));
    ball->grade.reset();
    if (has_none_bad_[v]) ball->grade = 0;
  }
  return *ball;
}

// None comes to be below the floor unless note_fused() hears of it. What is, and has no grade yet,
// is as it was in the input.
template <class Real>
std::uint8_t FuseCavity<Real>::grade_of(Ball* ball) {
  if (ball->grade) return *ball->grade;
  const bool may_be_bad = ball->shapes.may_have_bad(floor_.shapes);
  has_none_bad_[ball->shapes.vertex()] = !may_be_bad;
  std::uint16_t worst = 0;
  if (may_be_bad) {
    for (const std::uint32_t entry : ball->shapes.entries()) {
      std::uint16_t& grade = mesh_->remembered[entry >> 2];
      if (grade == 0) grade = grades_.grade_of(cubed_mean_ratio(mesh_->tets[entry >> 2]));
      worst = std::max(worst, grade);
    }
  }
  ball->grade = static_cast<std::uint8_t>(worst);
  return *ball->grade;
}

template <class Real>
double FuseCavity<Real>::cubed_mean_ratio(const Tet& tet) const {
  const auto& p = mesh_->positions;
  return shape_of(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]], unit_).cubed_mean_ratio();
}

// For a ball that has something below the floor: to the worst grade in the cavity. False if that is
// not so, or has been done.
template <class Real>
bool FuseCavity<Real>::lower_limit(Ball* ball) {
  if (limit_.least < floor_.least || grade_of(ball) == 0) return false;
  grade_ = grade_of(&of_vertex_);
  if (!fixed_) grade_ = std::max(grade_, grade_of(&ball_of(partner_, &of_partner_)));
  limit_ = limit_of(grades_.least(grade_));
  return true;
}

// The tetrahedra round one of the two, up to the first one that speaks against the position.
template <class Real>
std::optional<Reject> FuseCavity<Real>::judge_ball(Ball* ball, VertexId other) {
  limit_ = floor_;
  if (ball->grade) lower_limit(ball);
  BallShapes<Real>& shapes = ball->shapes;
  const auto local = shapes.local(position_);
  for (std::size_t first = 0; first < shapes.entries().size(); first += kLanes) {
    shapes.gather(first);
    const LaneMask good = shapes.good(first, local, other, limit_.shapes);
    if (all(good)) continue;
    auto reason = judge_group(shapes, first, local, good);
    if (reason == Reject::kQuality && lower_limit(ball)) {
      reason = judge_group(shapes, first, local, shapes.good(first, local, other, limit_.shapes));
    }
    if (reason) return reason;
  }
  return std::nullopt;
}

// Of four tetrahedra those that are not certainly good.
template <class Real>
std::optional<Reject> FuseCavity<Real>::judge_group(
    const BallShapes<Real>& ball, std::size_t first,
    const typename BallShapes<Real>::LocalPosition& local, const LaneMask& good) {
  const LaneMask bad = ball.bad(first, local, limit_.shapes);
  const std::size_t count = std::min(kLanes, ball.entries().size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    if (good[i] != 0) continue;
    failed_ = ball.entries()[first + i];
    if (bad[i] != 0) {
      return ball.flipped(first, local)[i] != 0 ? Reject::kFlip : Reject::kQuality;
    }
    if (const auto reason = judge_shape(failed_)) return reason;
  }
  return std::nullopt;
}

// A good shape has a volume that is certainly positive; of any other the sign is looked at more
// closely.
template <class Real>
std::optional<Reject> FuseCavity<Real>::judge_shape(std::uint32_t entry) const {
  const Tet& tet = mesh_->tets[entry >> 2];
  const auto& order = kCornerFirst[entry & 3u];
  const auto& p = mesh_->positions;
  const Vec3<Real>&b = p[tet[order[1]]], &c = p[tet[order[2]]], &d = p[tet[order[3]]];
  const CellShape shape = shape_of(position_, b, c, d, unit_);
  const double square = 432 * shape.det * shape.det;
  const double edges = cube(shape.edges);
  if (shape.det > 0 && square >= limit_.sure * edges) return std::nullopt;
  if (flips_as_written(position_, entry & 3u, tet, p)) return Reject::kFlip;
  if (square >= limit_.least * edges) return std::nullopt;
  return Reject::kQuality;
}

// In the ball, or in the first tetrahedron of the cavity that has the place, or nearly.
template <class Real>
auto FuseCavity<Real>::find_place(const BallShapes<Real>& ball, VertexId other) const -> Place {
  const Vec3<Real>& x = mesh_->positions[ball.vertex()];
  if (const auto entry = ball.entry_of_vertex(ball.local(position_), other)) {
    return place_in(*entry, x);
  }
  // Not one that goes, which may have no volume by now.
  Place best = place_in((affected_.empty() ? ball.entries() : affected_).front(), x);
  for (const std::uint32_t entry : affected_) {
    if (best.least() >= 0) break;
    const Place place = place_in(entry, x);
    if (place.least() > best.least()) best = place;
  }
  return best;
}

template <class Real>
auto FuseCavity<Real>::place_in(std::uint32_t entry, const Vec3<Real>& x) const -> Place {
  const Tet& tet = mesh_->tets[entry >> 2];
  const auto& order = kCornerFirst[entry & 3u];
  Place place{{tet[order[1]], tet[order[2]], tet[order[3]]}, {}};
  const auto from_position = [&](const Vec3<Real>& p) {
    return Point3{double{p.x} - position_.x, double{p.y} - position_.y, double{p.z} - position_.z};
  };
  const Point3 b = from_position(mesh_->positions[place.base[0]]);
  const Point3 c = from_position(mesh_->positions[place.base[1]]);
  const Point3 d = from_position(mesh_->positions[place.base[2]]);
  const Point3 to_x = from_position(x), cd = cross(c, d), bx = cross(b, to_x);
  const double whole = dot(b, cd);
  place.shares[1] = dot(to_x, cd) / whole;
  place.shares[2] = dot(d, bx) / whole;
  place.shares[3] = -dot(c, bx) / whole;
  place.shares[0] = 1 - place.shares[1] - place.shares[2] - place.shares[3];
  return place;
}

template <class Real>
void FuseCavity<Real>::list() {
  affected_.clear();
  deleted_.clear();
  of_vertex_.shapes.list(partner_, &affected_, &deleted_);
  if (fixed_) return;
  // What both have is there already.
  const std::size_t deleted = deleted_.size();
  of_partner_.shapes.list(of_vertex_.shapes.vertex(), &affected_, &deleted_);
  deleted_.resize(deleted);
}

// Along the base triangle's normal, which is the gradient of the tetrahedron's determinant.
template <class Real>
auto FuseCavity<Real>::obstacle() const -> Obstacle {
  const Tet& tet = mesh_->tets[failed_ >> 2];
  const auto& order = kCornerFirst[failed_ & 3u];
  const auto& p = mesh_->positions;
  const Vec3<Real>&b = p[tet[order[1]]], &c = p[tet[order[2]]], &d = p[tet[order[3]]];
  const CellShape shape = shape_of(position_, b, c, d, unit_);
  const double wanted = kPush * std::sqrt(limit_.sure * cube(shape.edges) / 432);
  const auto from_b = [&](const Vec3<Real>& x) {
    return Point3{(double{x.x} - b.x) * unit_, (double{x.y} - b.y) * unit_,
                  (double{x.z} - b.z) * unit_};
  };
  const Point3 gradient = cross(from_b(d), from_b(c));
  const double length = std::sqrt(dot(gradient, gradient));
  if (!(length > 0)) return {};
  return {{static_cast<float>(gradient[0] / length), static_cast<float>(gradient[1] / length),
           static_cast<float>(gradient[2] / length)},
          static_cast<float>((wanted - shape.det) / length)};
}

// Of two that are as near, the one with the lower id in the input.
template <class Real>
VertexId FuseCavity<Real>::nearer() const {
  const VertexId v = of_vertex_.shapes.vertex();
  if (partner_ == kNoVertex) return v;
  const auto distance = [&](VertexId u) {
    const Vec3<Real>& p = mesh_->positions[u];
    const double x = double{p.x} - position_.x, y = double{p.y} - position_.y;
    const double z = double{p.z} - position_.z;
    return x * x + y * y + z * z;
  };
  const double a = distance(v), b = distance(partner_);
  if (a == b) return mesh_->point_ids[v] < mesh_->point_ids[partner_] ? v : partner_;
  return a < b ? v : partner_;
}

template <class Real>
Interpolation FuseCavity<Real>::interpolation() const {
  Interpolation best;
  best.nearest = nearer();
  double deepest = -std::numeric_limits<double>::infinity();
  const auto& p = mesh_->positions;
  // Takes it if the position lies deeper in it; is it in it?
  const auto take_deeper = [&](TetId t) {
    const Tet& tet = mesh_->tets[t];
    std::array<double, 4> weights{};
    double sum = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto& order = kCornerFirst[c];
      weights[c] =
          determinant(position_, p[tet[order[1]]], p[tet[order[2]]], p[tet[order[3]]]).value;
      sum += weights[c];
    }
    for (double& w : weights) w /= sum;
    const double least = *std::min_element(weights.begin(), weights.end());
    if (least > deepest) {
      deepest = least;
      for (std::size_t c = 0; c < 4; ++c) best.from[c] = tet[kCornerFirst[c][0]];
      best.weights = weights;
    }
    return least >= 0;
  };
  for (const TetId t : deleted_) {
    if (take_deeper(t)) return best;
  }
  for (const std::uint32_t entry : affected_) {
    if (take_deeper(entry >> 2)) return best;
  }
  return best;
}

template class FuseCavity<float>;
template class FuseCavity<double>;

}  // namespace tetfusion
