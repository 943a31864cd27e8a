#include "compare/locator.h"

#include "compare/corner_weights.h"

namespace tetfusion {

namespace {

// Farther than that, the tree is faster.
constexpr int kMostSteps = 32;

double epsilon(ValueType type) { return type == ValueType::kFloat32 ? 0x1p-23 : 0x1p-52; }

}  // namespace

Locator::Locator(const SimplifiedMesh* mesh, ValueType coarsest_point_type)
    : mesh_(*mesh),
      rounding_(4 * epsilon(coarsest_point_type)),
      largest_extent_(largest_part(mesh->box.extent())),
      boundary_(&mesh->boundary),
      vertices_(mesh->points) {
  tree_.build(mesh_.tets.size(), mesh_.box.centre(), [&](std::size_t t) {
    PointBox box;
    for (const Point& p : mesh_.corners(static_cast<TetId>(t))) box.add(p);
    return box;
  });
}

Place Locator::locate(const Point& p, LocatorHint* hint, std::uint32_t part) const {
  Place place{};
  const bool can_walk = hint->tet != kNoTet && is_in(hint->tet, part);  // which leaves no part
  if (can_walk && walk(p, &hint->tet, &place)) return place;
  const bool found =
      tree_.find(p, 0, [&](TetId t) { return is_in(t, part) && holds(t, p, &place); });
  if (!found && !find_close(p, part, &place)) place = find_on_boundary(p, part, hint);
  hint->tet = place.tet;
  return place;
}

// From tetrahedron to tetrahedron, each time through a face beyond which the point lies.
bool Locator::walk(const Point& p, TetId* tet, Place* place) const {
  for (int step = 0; step < kMostSteps && *tet != kNoTet; ++step) {
    const auto& neighbours = mesh_.neighbours[*tet];
    __builtin_prefetch(&neighbours);
    const CornerVolumes volumes(mesh_.corners(*tet), p);
    const std::size_t exit = volumes.exit();
    if (exit == CornerVolumes::kNone) {
      const bool inside = volumes.are_positive() || box_holds(mesh_.corners(*tet), p);
      if (mesh_.flat[*tet] != 0 || !inside) return false;
      *place = {*tet, weights_of(volumes.values()), false, 0};
      return true;
    }
    *tet = neighbours[exit];
  }
  return false;
}

bool Locator::holds(TetId t, const Point& p, Place* place) const {
  if (mesh_.flat[t] != 0) return false;
  const auto weights = weights_in(mesh_.corners(t), p);
  if (weights) *place = {t, *weights, false, 0};
  return weights.has_value();
}

double Locator::tolerance(const Point& p, double extent) const {
  return rounding_ * (largest_part(p) + extent);
}

double Locator::rounding_in(const PointBox& box) const {
  const double largest = std::max(largest_part(box.low), largest_part(box.high));
  return rounding_ * (largest + largest_part(box.extent()));
}

// What is nearest in the tetrahedra round it, no farther than rounding explains. It lies on one of
// the faces that the point is beyond: in a sliver, whose height may be no more than that rounding,
// weights that are merely cut off at 0 would be those of another place.
bool Locator::find_close(const Point& p, std::uint32_t part, Place* place) const {
  double best = std::numeric_limits<double>::infinity();
  tree_.find(p, tolerance(p, largest_extent_), [&](TetId t) {
    if (mesh_.flat[t] != 0 || !is_in(t, part)) return false;
    const Corners corners = mesh_.corners(t);
    PointBox box;
    for (const Point& c : corners) box.add(c);
    const double most = tolerance(p, largest_part(box.extent()));
    for (std::size_t corner = 0; corner < 4; ++corner) {
      if (volume_at(corners, corner, p).value >= 0) continue;
      const auto& face = kFaceCorners[corner];
      const NearestOnTriangle nearest =
          nearest_on_triangle(p, {corners[face[0]], corners[face[1]], corners[face[2]]});
      if (nearest.squared > most * most || nearest.squared >= best) continue;
      best = nearest.squared;
      *place = {t, {}, false, 0};
      for (std::size_t i = 0; i < 3; ++i) place->weights[face[i]] = nearest.weights[i];
    }
    return false;
  });
  return best < std::numeric_limits<double>::infinity();
}

Place Locator::find_on_boundary(const Point& p, std::uint32_t part, LocatorHint* hint) const {
  const TriangleFinder::Found found = boundary_.nearest(p, hint->triangle, part);
  hint->triangle = found.triangle;
  const std::uint32_t side = mesh_.boundary_sides[found.triangle];
  const auto& face = kFaceCorners[side % 4];
  Place place{side / 4, {}, false, std::sqrt(found.nearest.squared)};
  PointBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    place.weights[face[i]] = found.nearest.weights[i];
    box.add(mesh_.points[mesh_.tets[place.tet][face[i]]]);
  }
  place.outside = place.distance > tolerance(p, largest_part(box.extent()));
  if (!place.outside) place.distance = 0;
  return place;
}

}  // namespace tetfusion
