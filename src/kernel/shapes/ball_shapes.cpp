#include "kernel/shapes/ball_shapes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernel/criteria.h"

namespace tetfusion {

namespace {

// Coordinates on the grid stay below this in the beginning; there is as much room for what moves.
constexpr double kGrid = 1 << 30;

// A unit of the grid is as much as rounding does to so many of them.
constexpr float kPrecision = 1 << 24;
using Lanes3 = std::array<Lanes, 3>;

Lanes3 difference(const Lanes3& a, const Lanes3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Lanes3 cross_lanes(const Lanes3& a, const Lanes3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Lanes dot_lanes(const Lanes3& a, const Lanes3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Lanes square(const Lanes3& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }

// A power of two that makes the largest of these numbers one near 1.
float scale_for(LaneMask numbers) {
  const Lanes x = to_lanes(numbers);
  const float largest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2]), 1.0F});
  const std::uint32_t exponent = std::bit_cast<std::uint32_t>(largest) >> 23;
  return std::bit_cast<float>((254 - exponent) << 23);
}

}  // namespace

template <class Real>
void GridPositions<Real>::reset(const Vector<Vec3<Real>>& positions) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};
  for (const Vec3<Real>& p : positions) {
    const std::array<double, 3> x{p.x, p.y, p.z};
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], x[a]);
      hi[a] = std::max(hi[a], x[a]);
    }
  }
  origin_ = lo;
  const double extent = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]});
  holds_ = std::isnormal(extent) && std::isnormal(kGrid / extent);
  scale_ = holds_ ? std::ldexp(1.0, std::ilogb(kGrid) - 1 - std::ilogb(extent)) : 1;
  points_.resize(positions.size());
  for (VertexId v = 0; v < positions.size(); ++v) move(v, positions[v]);
}

template <class Real>
std::array<double, 3> GridPositions<Real>::on_grid(const Vec3<Real>& position) const {
  return {(position.x - origin_[0]) * scale_, (position.y - origin_[1]) * scale_,
          (position.z - origin_[2]) * scale_};
}

template <class Real>
void GridPositions<Real>::move(VertexId v, const Vec3<Real>& position) {
  const std::array<double, 3> x = on_grid(position);
  for (std::size_t a = 0; a < 3; ++a) {
    const bool is_near = std::abs(x[a]) < kGrid;
    holds_ = holds_ && is_near;
    points_[v][a] = is_near ? static_cast<std::int32_t>(std::lrint(x[a])) : 0;
  }
  points_[v][3] = 0;
}

template <class Real>
void BallShapes<Real>::begin(const WorkMesh<Real>& mesh, const GridPositions<Real>& grid,
                             VertexId v, std::span<const std::uint32_t> ball) {
  mesh_ = &mesh;
  grid_ = &grid;
  vertex_ = v;
  entries_ = ball;
  gathered_ = 0;
  groups_.resize((ball.size() + kLanes - 1) / kLanes);
  if (ball.empty()) return;
  origin_ = grid.at(v);
  const Tet& one = mesh.tets[ball[0] >> 2];
  scale_ = scale_for(grid.at(one[(ball[0] + 1) & 3u]) - origin_);
  grid_reach_ = grid.holds() ? kPrecision * scale_ : std::numeric_limits<float>::infinity();
}

template <class Real>
void BallShapes<Real>::gather_next() {
  Group& group = groups_[gathered_ / kLanes];
  std::array<Lanes3, 3>& p = group.base;  // b, c and d
  std::array<LaneMask, kLanes> tets;
  std::array<std::array<LaneMask, kLanes>, 3> rows;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const std::uint32_t entry = entries_[std::min(gathered_ + i, entries_.size() - 1)];
    const Tet& tet = mesh_->tets[entry >> 2];
    const auto& order = kCornerFirst[entry & 3u];
    std::memcpy(&tets[i], &tet, sizeof tet);
    for (std::size_t k = 0; k < 3; ++k) rows[k][i] = grid_->at(tet[order[k + 1]]) - origin_;
  }
  group.corners = transposed(tets);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [x, y, z, none] = transposed(rows[k]);
    p[k] = {to_lanes(x) * scale_, to_lanes(y) * scale_, to_lanes(z) * scale_};
  }
  const Lanes3 e = difference(p[1], p[0]), f = difference(p[2], p[0]), h = difference(p[2], p[1]);
  group.normal = {f[1] * e[2] - f[2] * e[1], f[2] * e[0] - f[0] * e[2], f[0] * e[1] - f[1] * e[0]};
  for (std::size_t a = 0; a < 3; ++a) {
    group.centre[a] = (p[0][a] + p[1][a] + p[2][a]) * (1.0F / 3);
  }
  group.edges = (square(e) + square(f) + square(h)) * (4.0F / 3);
  // The centre's distance, and the corners' from it.
  const Lanes far = 2.0F * square(group.centre) + group.edges;
  group.reach = std::sqrt(std::max({far[0], far[1], far[2], far[3]})) + grid_reach_;
  gathered_ += kLanes;
}

template <class Real>
void BallShapes<Real>::list(VertexId other, Vector<std::uint32_t>* without,
                            Vector<TetId>* with) const {
  const std::size_t before = without->size(), before_with = with->size();
  without->resize(before + entries_.size());
  with->resize(before_with + entries_.size());
  std::uint32_t* entry = without->data() + before;
  TetId* tet = with->data() + before_with;
  for (std::size_t first = 0; first < entries_.size(); first += kLanes) {
    const LaneMask have = groups_[first / kLanes].have(other);
    const std::size_t count = std::min(kLanes, entries_.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      *entry = entries_[first + i];
      *tet = entries_[first + i] >> 2;
      entry += have[i] == 0 ? 1 : 0;
      tet += have[i] == 0 ? 0 : 1;
    }
  }
  without->resize(static_cast<std::size_t>(entry - without->data()));
  with->resize(static_cast<std::size_t>(tet - with->data()));
}

template <class Real>
auto BallShapes<Real>::local(const Vec3<Real>& position) const -> LocalPosition {
  const std::array<double, 3> x = grid_->on_grid(position);
  LocalPosition local{};
  float far = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    local.x[a] = static_cast<float>(x[a] - origin_[a]) * scale_;
    far = std::max(far, std::abs(local.x[a]));
  }
  local.far = far;
  return local;
}

// The ray from the position to the vertex goes through one base triangle of the cavity.
template <class Real>
std::optional<std::uint32_t> BallShapes<Real>::entry_of_vertex(const LocalPosition& local,
                                                               VertexId other) const {
  const Lanes3 to_place{Lanes{} + local.x[0], Lanes{} + local.x[1], Lanes{} + local.x[2]};
  const Lanes3 to_vertex{-to_place[0], -to_place[1], -to_place[2]};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const Lanes3 b = difference(group.base[0], to_place), c = difference(group.base[1], to_place);
    const Lanes3 d = difference(group.base[2], to_place);
    const Lanes3 b_vertex = cross_lanes(b, to_vertex);
    const LaneMask inside = (dot_lanes(to_vertex, cross_lanes(c, d)) >= 0.0F) &
                            (dot_lanes(d, b_vertex) >= 0.0F) & (dot_lanes(c, b_vertex) <= 0.0F) &
                            ~group.have(other);
    for (std::size_t i = 0; i < kLanes; ++i) {
      if (inside[i] != 0) return entries_[std::min(kLanes * g + i, entries_.size() - 1)];
    }
  }
  return std::nullopt;
}

template <class Real>
bool BallShapes<Real>::may_have_bad(const ShapeFloors& floors) {
  const LocalPosition here{};
  for (std::size_t first = 0; first < entries_.size(); first += kLanes) {
    gather(first);
    if (!all(good(first, here, kNoVertex, floors))) return true;
  }
  return false;
}

template class GridPositions<float>;
template class GridPositions<double>;
template class BallShapes<float>;
template class BallShapes<double>;

}  // namespace tetfusion
