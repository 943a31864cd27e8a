#include "kernel/sheet_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/near_surface.h"

namespace tetfusion {

namespace {

// Heights up to this share of the width are what coordinates of single precision make of a plane.
constexpr double kFlat = 1e-5;

// In the unit. So little is no rise; so far may a part of the boundary move in a round and count as
// still, as where flat parts and straight edges meet at an angle, and a vertex goes along the edge
// but for what single precision and the pull of best_position() make of it; and so far may one move
// that rises: a quarter to a half of a cell of the grid.
constexpr double kRoundingOfHeights = 1e-12;
constexpr double kStill = 0x1p-20;
constexpr double kReach = 1.0 / 256;

}  // namespace

template <class Real>
void SheetFusion<Real>::begin(const WorkMesh<Real>* mesh, Sheets<Real>* sheets,
                              const SheetLimits& limits) {
  mesh_ = mesh;
  sheets_ = sheets;
  limits_ = limits;
  moved_.assign(mesh->vertex_count(), 0.0F);
}

// In the unit.
template <class Real>
Point3 SheetFusion<Real>::about_v(const Vec3<Real>& p) const {
  const Vec3<Real>& o = mesh_->positions[v_];
  return {(double{p.x} - o.x) * limits_.unit, (double{p.y} - o.y) * limits_.unit,
          (double{p.z} - o.z) * limits_.unit};
}

template <class Real>
bool SheetFusion<Real>::choose(VertexId v, VertexId partner, bool fixed, Along along) {
  v_ = v;
  partner_ = partner;
  fixed_ = fixed;
  along_ = along;
  if (!sheets_->find_fan(v, &fan_v_) || !fan_v_.turn_to(partner)) return false;
  if (!fixed && (!sheets_->find_fan(partner, &fan_partner_) || !fan_partner_.turn_to(v))) {
    return false;
  }
  if (along == Along::kLine && !find_sides()) return false;
  if (!sheets_->may_contract(v, fan_v_, partner)) return false;
  find_places(fan_v_, &pair_.ring);
  pair_.partner_ring.clear();
  if (!fixed) find_places(fan_partner_, &pair_.partner_ring);
  deviation_before_ = largest(mesh_->deviations);
  moved_before_ = largest(moved_);
  return true;
}

template <class Real>
void SheetFusion<Real>::find_places(const SheetFan& fan, std::vector<Point3>* ring) const {
  ring->clear();
  for (const VertexId u : fan.ring) ring->push_back(at(u));
}

// The line goes on from both ends of an edge of it.
template <class Real>
bool SheetFusion<Real>::find_sides() {
  // No triangle has two edges of the line.
  const auto find_end = [](const SheetFan& fan) {
    if (fan.sharp_edges != 2 || fan.sharp[0] == 0) return std::size_t{0};
    const auto end = static_cast<std::size_t>(std::find(fan.sharp.begin() + 1, fan.sharp.end(), 1) -
                                              fan.sharp.begin());
    return end == 1 || end + 1 == fan.size() ? 0 : end;
  };
  pair_.end = find_end(fan_v_);
  if (pair_.end == 0) return false;
  if (fixed_) return true;
  pair_.partner_end = find_end(fan_partner_);
  return pair_.partner_end != 0 && fan_v_.ring[pair_.end] != fan_partner_.ring[pair_.partner_end];
}

// Of the vertices of the old patch.
template <class Real>
float SheetFusion<Real>::largest(const Vector<float>& values) const {
  float most = values[v_];
  for (const VertexId u : fan_v_.ring) most = std::max(most, values[u]);
  if (fixed_) return most;
  for (const VertexId u : fan_partner_.ring) most = std::max(most, values[u]);
  return most;
}

template <class Real>
Vec3<Real> SheetFusion<Real>::on_edge(double t) const {
  const Vec3<Real>&a = mesh_->positions[v_], &b = mesh_->positions[partner_];
  if (t <= 0) return a;
  if (t >= 1) return b;
  return {static_cast<Real>(a.x + t * (double{b.x} - a.x)),
          static_cast<Real>(a.y + t * (double{b.y} - a.y)),
          static_cast<Real>(a.z + t * (double{b.z} - a.z))};
}

template <class Real>
Vec3<Real> SheetFusion<Real>::flattened(const Vec3<Real>& position) const {
  if (along_ == Along::kLine) {
    const Point3& edge = pair_.partner();
    return on_edge(dot(about_v(position), edge) / dot(edge, edge));
  }
  Point3 normal{};
  const std::size_t n = pair_.ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Point3 area = cross(pair_.ring[i], pair_.ring[(i + 1) % n]);
    for (std::size_t k = 0; k < 3; ++k) normal[k] += area[k];
  }
  const double length = std::sqrt(dot(normal, normal));
  if (!(length > 0)) return position;
  for (double& c : normal) c /= length;
  double width = 0, height = 0;
  for (const auto* ring : {&pair_.ring, &pair_.partner_ring}) {
    for (const Point3& p : *ring) {
      width = std::max(width, dot(p, p));
      height = std::max(height, std::abs(dot(p, normal)));
    }
  }
  if (!(height <= kFlat * std::sqrt(width))) return position;
  const Point3 p = about_v(position);
  const double off = dot(p, normal) / limits_.unit;
  return {static_cast<Real>(position.x - off * normal[0]),
          static_cast<Real>(position.y - off * normal[1]),
          static_cast<Real>(position.z - off * normal[2])};
}

template <class Real>
bool SheetFusion<Real>::allows(const Vec3<Real>& position) {
  position_ = about_v(position);
  double distance = 0;
  if (!(along_ == Along::kSheet ? measure_disc(&distance) : measure_line(&distance))) return false;
  const auto sum = [distance](float before) {
    return std::nextafter(static_cast<float>(double{before} + distance),
                          std::numeric_limits<float>::infinity());
  };
  deviation_ = sum(deviation_before_);
  moved_here_ = sum(moved_before_);
  return deviation_ <= limits_.max_deviation;
}

template <class Real>
bool SheetFusion<Real>::measure_disc(double* distance) {
  collect_disc(pair_, position_, &change_);
  old_ = change_.triangles;
  outline_moves_ = false;
  const auto disc = measure(change_);
  if (disc) *distance = disc->distance;
  return disc && !may_meet_another(*disc, disc->rise) && is_alone(disc->distance);
}

// First the line goes to its new place, and draws the triangles with it: they move no further than
// its points do. Then each side is a patch of its own.
template <class Real>
bool SheetFusion<Real>::measure_line(double* distance) {
  const MovedLine line = move_line(pair_, position_);
  const double moved = distance_of(pair_, line);
  double sides = 0;
  outline_moves_ = moved > kStill;
  for (const LineSide side : {LineSide::kLeft, LineSide::kRight}) {
    collect_side(pair_, line, side, &change_);
    collect_old_side(pair_, side, &old_);
    const auto patch = measure(change_);
    if (!patch || may_meet_another(*patch, patch->rise + moved)) return false;
    if (!is_alone(patch->distance + moved)) return false;
    sides = std::max(sides, patch->distance);
  }
  *distance = moved + sides;
  return true;
}

// What a patch that rises would meet is another part of the boundary, somewhere above, that looks
// down at it: a way up that enters the volume there crosses such a triangle. Parts that other
// chunks have may have risen, too, since the round began: none may when it has moved by more than
// kReach, or there are some that it may not know as near as it has moved. Where it knows all of
// them, as far as they may have come, it looks at the triangles.
template <class Real>
bool SheetFusion<Real>::may_meet_another(const PatchDistance& patch, double rise) const {
  if (limits_.facing == nullptr || !(rise > kRoundingOfHeights)) return false;
  if ((mesh_->marks[v_] & kOnBoundary) == 0) return false;  // volume on both sides
  const double moved = moved_before_ + patch.distance + rise;
  if (moved <= kStill) return false;
  const bool is_near = moved <= kReach;
  if (is_near && !limits_.facing->may_face(in_mesh(box_of_patch(kReach)), patch.normal))
    return false;
  if (limits_.stays_alone && !is_near) return true;
  return !limits_.triangles->knows(in_mesh(box_of_patch(std::max(kReach, moved)))) ||
         meets_another(patch.normal);
}

// Does a triangle reach into what lies between the patch and its fan? Where the outline moves, what
// is behind one of them must be behind both.
template <class Real>
bool SheetFusion<Real>::meets_another(const Point3& normal) const {
  const FacingBox box = box_of_patch(0);
  const Heights heights = heights_along(normal);
  return limits_.triangles->any(in_mesh(box), [&](const BoundaryTriangles::Corners& corners) {
    return is_in_the_way(corners, box, normal, heights);
  });
}

// Nothing is below or above them where a triangle shows its back: that is looked at more closely.
template <class Real>
auto SheetFusion<Real>::heights_along(const Point3& normal) const -> Heights {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Heights heights{kInfinity, -kInfinity};
  bool is_seen = true;
  const auto look = [&](const Triangle3& t, bool is_of_fan) {
    is_seen = is_seen && dot(cross(minus(t[1], t[0]), minus(t[2], t[0])), normal) > 0;
    for (const Point3& p : t) {
      heights.least = std::min(heights.least, dot(p, normal));
      if (is_of_fan) heights.most_of_fan = std::max(heights.most_of_fan, dot(p, normal));
    }
    return true;
  };
  for (const Triangle3& t : old_) look(t, false);
  for_each_of_fan([&](const Triangle3& t) { return look(t, true); });
  return is_seen ? heights : Heights{-kInfinity, kInfinity};
}

// Until use() says false of a triangle; whether it did of none.
template <class Real>
template <class Use>
bool SheetFusion<Real>::for_each_of_fan(Use use) const {
  const auto& chain = change_.chain;
  for (std::size_t i = 0; i + (change_.closed ? 0 : 1) < chain.size(); ++i) {
    if (!use(Triangle3{change_.apex, chain[i], chain[(i + 1) % chain.size()]})) return false;
  }
  return true;
}

template <class Real>
bool SheetFusion<Real>::is_in_the_way(const BoundaryTriangles::Corners& corners,
                                      const FacingBox& box, const Point3& normal,
                                      const Heights& heights) const {
  for (const VertexId u : corners) {
    const bool goes = u == v_ || (u == partner_ && !fixed_);
    if (goes || mesh_->incidence[u] == 0) return false;
  }
  const Triangle3 triangle{at(corners[0]), at(corners[1]), at(corners[2])};
  const FacingBox around = box_round(triangle[0], triangle[1], triangle[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    if (around.lo[i] > box.hi[i] || around.hi[i] < box.lo[i]) return false;
  }
  // The other side of a wall is as clear as that.
  const auto [low, high] =
      std::minmax({dot(triangle[0], normal), dot(triangle[1], normal), dot(triangle[2], normal)});
  if (high < heights.least - 2 * kStill || low > heights.most_of_fan + 2 * kStill) return false;
  const auto is_on = [&](Side side) {
    return for_each_of_fan(
        [&](const Triangle3& one) { return lies_on_side(triangle, one, normal, side, kStill); });
  };
  const bool is_behind = std::all_of(old_.begin(), old_.end(), [&](const Triangle3& one) {
    return lies_on_side(triangle, one, normal, Side::kBehind, kStill);
  });
  return !(is_behind && (!outline_moves_ || is_on(Side::kBehind))) && !is_on(Side::kBefore);
}

// The new triangles of the boundary, for those who come after.
template <class Real>
void SheetFusion<Real>::note_fused(VertexId kept) {
  moved_[kept] = moved_here_;
  if (limits_.facing == nullptr || (mesh_->marks[v_] & kOnBoundary) == 0) return;
  const auto add = [&](const SheetFan& fan) {
    for (std::size_t i = 1; i + 1 < fan.size(); ++i) {
      const VertexId a = fan.ring[i], b = fan.ring[i + 1];
      limits_.triangles->add({kept, a, b}, in_mesh(box_round(position_, at(a), at(b))));
    }
  };
  add(fan_v_);
  if (!fixed_) add(fan_partner_);
}

// A point that comes to lie outside is then nearest to what is round its own place.
template <class Real>
bool SheetFusion<Real>::is_alone(double distance) const {
  if (!limits_.stays_alone || limits_.facing == nullptr || distance <= kOnSurface) return true;
  if ((mesh_->marks[v_] & kOnBoundary) == 0) return true;
  const double furthest = std::max(limits_.deviation_before, double{deviation_before_} + distance);
  return limits_.facing->looks_one_way(in_mesh(box_of_patch(2 * furthest + kReach)));
}

template <class Real>
FacingBox SheetFusion<Real>::box_of_patch(double wider) const {
  FacingBox box{change_.apex, change_.apex};
  for (const auto* triangles : {&change_.triangles, &old_}) {
    for (const Triangle3& triangle : *triangles) {
      for (const Point3& p : triangle) box.add(p);
    }
  }
  box.widen(wider);
  return box;
}

// Back from about_v().
template <class Real>
Point3 SheetFusion<Real>::in_mesh(const Point3& p) const {
  const Vec3<Real>& o = mesh_->positions[v_];
  return {p[0] / limits_.unit + o.x, p[1] / limits_.unit + o.y, p[2] / limits_.unit + o.z};
}

template class SheetFusion<float>;
template class SheetFusion<double>;

}  // namespace tetfusion
