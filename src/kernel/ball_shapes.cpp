#include "kernel/ball_shapes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernel/criteria.h"

namespace tetfusion {

namespace {

// Coordinates on the grid stay below this in the beginning; there is as much room for what moves.
constexpr double kGrid = 1 << 30;

// What rounding does to m.(x - g), as a share of the edges' squares times the largest coordinate,
// is below nine times 2^-24: coordinates are rounded once, centres and edges of them again, and
// products and sums of these. What it does to the squares themselves counts a twentieth of that, as
// the determinant is compared with no more than a twentieth of their power 3/2.
constexpr float kRounding = 1.0F / (1 << 20);
// A unit of the grid is as much as rounding does to so many of them.
constexpr float kPrecision = 1 << 24;
using Lanes3 = std::array<Lanes, 3>;

Lanes3 difference(const Lanes3& a, const Lanes3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
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
void BallShapes<Real>::gather(const WorkMesh<Real>& mesh, const GridPositions<Real>& grid,
                              VertexId v, std::span<const std::uint32_t> ball) {
  grid_ = &grid;
  vertex_ = v;
  entries_ = ball;
  bad_ = Bad::kUnknown;
  groups_.resize((ball.size() + kLanes - 1) / kLanes);
  if (ball.empty()) return;
  origin_ = grid.at(v);
  const Tet& one = mesh.tets[ball[0] >> 2];
  scale_ = scale_for(grid.at(one[(ball[0] + 1) & 3u]) - origin_);
  Lanes reach{};  // squared
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    std::array<Lanes3, 3> p;  // of b, c and d
    std::array<std::uint32_t, kLanes> entries;
    for (std::size_t i = 0; i < kLanes; ++i) {
      entries[i] = ball[std::min(kLanes * g + i, ball.size() - 1)];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<Lanes, kLanes> rows;
      for (std::size_t i = 0; i < kLanes; ++i) {
        const Tet& tet = mesh.tets[entries[i] >> 2];
        const VertexId u = tet[kCornerFirst[entries[i] & 3u][k + 1]];
        rows[i] = to_lanes(grid.at(u) - origin_) * scale_;
      }
      const auto columns = transposed(rows);
      p[k] = {columns[0], columns[1], columns[2]};
    }
    std::array<LaneMask, kLanes> tets;
    for (std::size_t i = 0; i < kLanes; ++i) {
      std::memcpy(&tets[i], &mesh.tets[entries[i] >> 2], sizeof(Tet));
    }
    group.corners = transposed(tets);
    const Lanes3 e = difference(p[1], p[0]), f = difference(p[2], p[0]), h = difference(p[2], p[1]);
    group.normal = {f[1] * e[2] - f[2] * e[1], f[2] * e[0] - f[0] * e[2],
                    f[0] * e[1] - f[1] * e[0]};
    for (std::size_t a = 0; a < 3; ++a) {
      group.centre[a] = (p[0][a] + p[1][a] + p[2][a]) * (1.0F / 3);
    }
    group.edges = (square(e) + square(f) + square(h)) * (4.0F / 3);
    // The centre's distance, and the corners' from it.
    const Lanes far = 2.0F * square(group.centre) + group.edges;
    reach = select(far > reach, far, reach);
  }
  reach_ = grid.holds()
               ? std::sqrt(std::max({reach[0], reach[1], reach[2], reach[3]})) + kPrecision * scale_
               : std::numeric_limits<float>::infinity();
}

template <class Real>
bool BallShapes<Real>::has(std::size_t entry, VertexId other) const {
  const auto& corners = groups_[entry / kLanes].corners;
  const auto id = static_cast<std::int32_t>(other);
  const std::size_t i = entry % kLanes;
  return corners[0][i] == id || corners[1][i] == id || corners[2][i] == id || corners[3][i] == id;
}

template <class Real>
auto BallShapes<Real>::place(const Vec3<Real>& position) const -> Place {
  const std::array<double, 3> x = grid_->on_grid(position);
  Place place{};
  float far = reach_;
  for (std::size_t a = 0; a < 3; ++a) {
    place.x[a] = static_cast<float>(x[a] - origin_[a]) * scale_;
    far = std::max(far, std::abs(place.x[a]));
  }
  place.error = kRounding * far;
  return place;
}

// Whose base triangle's plane is the first behind the vertex, seen from the place: the share that
// the new vertex has there is the least.
template <class Real>
std::size_t BallShapes<Real>::entry_of_vertex(const Place& place, VertexId other) const {
  Lanes least = Lanes{} + std::numeric_limits<float>::infinity();
  LaneMask at{};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    const Lanes from_centre = group.normal[0] * group.centre[0] +
                              group.normal[1] * group.centre[1] + group.normal[2] * group.centre[2];
    const Lanes to_place =
        group.normal[0] * place.x[0] + group.normal[1] * place.x[1] + group.normal[2] * place.x[2];
    const Lanes share = -from_centre / (to_place - from_centre);
    const LaneMask is_less = ~group.have(other) & (share < least);
    least = select(is_less, share, least);
    at = is_less ? LaneMask{} + static_cast<std::int32_t>(g) : at;
  }
  std::size_t lane = 0;
  for (std::size_t i = 1; i < kLanes; ++i) lane = least[i] < least[lane] ? i : lane;
  const std::size_t entry = static_cast<std::size_t>(at[lane]) * kLanes + lane;
  return std::min(entry, entries_.size() - 1);
}

template <class Real>
bool BallShapes<Real>::may_have_bad(const ShapeFloors& floors) {
  if (bad_ == Bad::kUnknown) {
    bad_ = Bad::kNone;
    const Place here{{}, kRounding * reach_};
    for (std::size_t first = 0; first < entries_.size(); first += kLanes) {
      if (!all(judge(first, here, kNoVertex, floors).good)) bad_ = Bad::kSome;
    }
  }
  return bad_ == Bad::kSome;
}

template class GridPositions<float>;
template class GridPositions<double>;
template class BallShapes<float>;
template class BallShapes<double>;

}  // namespace tetfusion
