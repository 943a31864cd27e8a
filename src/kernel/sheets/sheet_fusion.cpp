#include "kernel/sheets/sheet_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetfusion {

namespace {

// Heights up to this share of the width are what coordinates of single precision make of a plane.
constexpr double kFlat = 1e-5;

}  // namespace

template <class Real>
void SheetFusion<Real>::begin(const WorkMesh<Real>* mesh, Sheets<Real>* sheets,
                              const SheetLimits& limits) {
  mesh_ = mesh;
  sheets_ = sheets;
  limits_ = limits;
  surroundings_.begin(mesh, limits.surroundings);
  moved_.assign(mesh->vertex_count(), 0.0F);
}

template <class Real>
bool SheetFusion<Real>::choose(VertexId v, VertexId partner, bool fixed, Along along) {
  v_ = v;
  partner_ = partner;
  fixed_ = fixed;
  along_ = along;
  frame_ = {mesh_->positions[v], limits_.unit};
  if (!sheets_->find_fan(v, &fan_v_) || !fan_v_.turn_to(partner)) return false;
  if (!fixed && (!sheets_->find_fan(partner, &fan_partner_) || !fan_partner_.turn_to(v))) {
    return false;
  }
  if (along == Along::kLine && !find_sides()) return false;
  may_contract_.reset();
  find_places(fan_v_, &pair_.ring);
  pair_.partner_ring.clear();
  if (!fixed) find_places(fan_partner_, &pair_.partner_ring);
  deviation_before_ = largest(mesh_->deviations);
  moved_before_ = largest(moved_);
  surroundings_.choose(frame_, v, partner, fixed);
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
    return on_edge(dot(frame_.local(position), edge) / dot(edge, edge));
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
  const Point3 p = frame_.local(position);
  const double off = dot(p, normal) / limits_.unit;
  return {static_cast<Real>(position.x - off * normal[0]),
          static_cast<Real>(position.y - off * normal[1]),
          static_cast<Real>(position.z - off * normal[2])};
}

template <class Real>
bool SheetFusion<Real>::may_contract() {
  if (!may_contract_) {
    may_contract_ = sheets_->may_contract(v_, fan_v_, partner_, fixed_ ? nullptr : &fan_partner_);
  }
  return *may_contract_;
}

template <class Real>
bool SheetFusion<Real>::allows(const Vec3<Real>& position) {
  if (!may_contract()) return false;
  position_ = frame_.local(position);
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
  collect_disc(pair_, position_, &patch_.change);
  patch_.old = patch_.change.triangles;
  patch_.outline_moved = 0;
  const auto disc = measure(patch_.change);
  if (disc) *distance = disc->distance;
  return disc && may_move(*disc);
}

// First the line goes to its new place, and draws the triangles with it: they move no further than
// its points do. Then each side is a patch of its own.
template <class Real>
bool SheetFusion<Real>::measure_line(double* distance) {
  const MovedLine line = move_line(pair_, position_);
  patch_.outline_moved = distance_of(pair_, line);
  double sides = 0;
  for (const LineSide side : {LineSide::kLeft, LineSide::kRight}) {
    collect_side(pair_, line, side, &patch_.change);
    collect_old_side(pair_, side, &patch_.old);
    const auto patch = measure(patch_.change);
    if (!patch || !may_move(*patch)) return false;
    sides = std::max(sides, patch->distance);
  }
  *distance = patch_.outline_moved + sides;
  return true;
}

// As far as other parts of the boundary go.
template <class Real>
bool SheetFusion<Real>::may_move(const PatchDistance& distance) const {
  return !surroundings_.may_meet_another(patch_, distance, moved_before_) &&
         surroundings_.is_alone(patch_, distance.distance + patch_.outline_moved,
                                deviation_before_);
}

template <class Real>
void SheetFusion<Real>::note_fused(VertexId kept) {
  moved_[kept] = moved_here_;
  surroundings_.note_fused(kept, position_, fan_v_);
  if (!fixed_) surroundings_.note_fused(kept, position_, fan_partner_);
}

template class SheetFusion<float>;
template class SheetFusion<double>;

}  // namespace tetfusion
