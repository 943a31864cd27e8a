#include "kernel/sheets/patch_surroundings.h"

#include <algorithm>
#include <limits>

#include "kernel/sheets/near_surface.h"

namespace tetfusion {

namespace {

// In the unit. So little is no rise; so far may a part of the boundary move in a round and count as
// still, as where flat parts and straight edges meet at an angle, and a vertex goes along the edge
// but for what single precision and the pull of best_position() make of it; and so far may one move
// that rises: a quarter to a half of a cell of the grid.
constexpr double kRoundingOfHeights = 1e-12;
constexpr double kStill = 0x1p-20;
constexpr double kReach = 1.0 / 256;

FacingBox box_of_patch(const MovingPatch& patch, double wider) {
  FacingBox box{patch.change.apex, patch.change.apex};
  for (const auto* triangles : {&patch.change.triangles, &patch.old}) {
    for (const Triangle3& triangle : *triangles) {
      for (const Point3& p : triangle) box.add(p);
    }
  }
  box.widen(wider);
  return box;
}

// Until use() says false of a triangle; whether it did of none.
template <class Use>
bool for_each_of_fan(const PatchChange& change, Use use) {
  const auto& chain = change.chain;
  for (std::size_t i = 0; i + (change.closed ? 0 : 1) < chain.size(); ++i) {
    if (!use(Triangle3{change.apex, chain[i], chain[(i + 1) % chain.size()]})) return false;
  }
  return true;
}

}  // namespace

template <class Real>
void PatchSurroundings<Real>::begin(const WorkMesh<Real>* mesh, const SurroundingsLimits& limits) {
  mesh_ = mesh;
  limits_ = limits;
}

template <class Real>
void PatchSurroundings<Real>::choose(const LocalFrame<Real>& frame, VertexId v, VertexId partner,
                                     bool fixed) {
  frame_ = frame;
  v_ = v;
  partner_ = partner;
  fixed_ = fixed;
}

// What a patch that rises would meet is another part of the boundary, somewhere above, that looks
// down at it: a way up that enters the volume there crosses such a triangle. Parts that other
// chunks have may have risen, too, since the round began: none may when it has moved by more than
// kReach, or there are some that it may not know as near as it has moved. Where it knows all of
// them, as far as they may have come, it looks at the triangles.
template <class Real>
bool PatchSurroundings<Real>::may_meet_another(const MovingPatch& patch,
                                               const PatchDistance& distance,
                                               double moved_before) const {
  const double rise = distance.rise + patch.outline_moved;
  if (limits_.facing == nullptr || !(rise > kRoundingOfHeights) || !is_boundary()) return false;
  const double moved = moved_before + distance.distance + rise;
  if (moved <= kStill) return false;
  const bool is_near = moved <= kReach;
  if (is_near &&
      !limits_.facing->may_face(frame_.in_mesh(box_of_patch(patch, kReach)), distance.normal)) {
    return false;
  }
  if (limits_.stays_alone && !is_near) return true;
  const FacingBox reach = box_of_patch(patch, std::max(kReach, moved));
  return !limits_.triangles->knows(frame_.in_mesh(reach)) || meets_another(patch, distance.normal);
}

// Does a triangle reach into what lies between the patch and its fan? Where the outline moves, what
// is behind one of them must be behind both.
template <class Real>
bool PatchSurroundings<Real>::meets_another(const MovingPatch& patch, const Point3& normal) const {
  const FacingBox box = box_of_patch(patch, 0);
  const Heights heights = heights_along(patch, normal);
  return limits_.triangles->any(frame_.in_mesh(box),
                                [&](const BoundaryTriangles::Corners& corners) {
                                  return is_in_the_way(corners, patch, box, normal, heights);
                                });
}

// Nothing is below or above them where a triangle shows its back: that is looked at more closely.
template <class Real>
auto PatchSurroundings<Real>::heights_along(const MovingPatch& patch, const Point3& normal)
    -> Heights {
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
  for (const Triangle3& t : patch.old) look(t, false);
  for_each_of_fan(patch.change, [&](const Triangle3& t) { return look(t, true); });
  return is_seen ? heights : Heights{-kInfinity, kInfinity};
}

template <class Real>
bool PatchSurroundings<Real>::is_in_the_way(const BoundaryTriangles::Corners& corners,
                                            const MovingPatch& patch, const FacingBox& box,
                                            const Point3& normal, const Heights& heights) const {
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
    return for_each_of_fan(patch.change, [&](const Triangle3& one) {
      return lies_on_side(triangle, one, normal, side, kStill);
    });
  };
  const bool is_behind = std::all_of(patch.old.begin(), patch.old.end(), [&](const Triangle3& one) {
    return lies_on_side(triangle, one, normal, Side::kBehind, kStill);
  });
  return !(is_behind && (!(patch.outline_moved > kStill) || is_on(Side::kBehind))) &&
         !is_on(Side::kBefore);
}

// A point that comes to lie outside is then nearest to what is round its own place.
template <class Real>
bool PatchSurroundings<Real>::is_alone(const MovingPatch& patch, double distance,
                                       double deviation_before) const {
  if (!limits_.stays_alone || limits_.facing == nullptr || distance <= kOnSurface) return true;
  if (!is_boundary()) return true;
  const double furthest = std::max(limits_.deviation_before, deviation_before + distance);
  return limits_.facing->looks_one_way(frame_.in_mesh(box_of_patch(patch, 2 * furthest + kReach)));
}

template <class Real>
void PatchSurroundings<Real>::note_fused(VertexId kept, const Point3& position,
                                         const SheetFan& fan) const {
  if (limits_.facing == nullptr || !is_boundary()) return;
  for (std::size_t i = 1; i + 1 < fan.size(); ++i) {
    const VertexId a = fan.ring[i], b = fan.ring[i + 1];
    limits_.triangles->add(
        {kept, a, b}, {frame_.in_mesh(position), frame_.in_mesh(at(a)), frame_.in_mesh(at(b))});
  }
}

template class PatchSurroundings<float>;
template class PatchSurroundings<double>;

}  // namespace tetfusion
