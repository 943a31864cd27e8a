#include "generate/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/mix.h"

namespace tetfusion {

namespace {

// Where the cubes are smallest, as a share of the cubes along x, y and z.
constexpr std::array<double, 3> kFeature{0.35, 0.5, 0.65};

// Corners of a cube: bit 0 is x, bit 1 y, bit 2 z.
using CubeTet = std::array<int, 4>;

constexpr int component(int corner, int axis) { return corner >> axis & 1; }

constexpr int determinant_of(const CubeTet& t) {
  int m[3][3]{};
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis)
      m[row][axis] = component(t[row + 1], axis) - component(t[0], axis);
  }
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

constexpr CubeTet wound(CubeTet t) {
  if (determinant_of(t) < 0) std::swap(t[2], t[3]);
  return t;
}

// The diagonals of the faces join corners of even x + y + z, counted over the whole lattice: [0] is
// for cubes whose own corner is even, [1] the mirror image for the others.
constexpr std::array<std::array<CubeTet, 5>, 2> make_five() {
  const std::array<CubeTet, 5> even{
      {{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}}};
  std::array<std::array<CubeTet, 5>, 2> five{};
  for (std::size_t i = 0; i < even.size(); ++i) {
    CubeTet mirrored = even[i];
    for (int& c : mirrored) c ^= 1;
    five[0][i] = wound(even[i]);
    five[1][i] = wound(mirrored);
  }
  return five;
}

// One for each order of walking the axes from corner 0 to corner 7.
constexpr std::array<CubeTet, 6> make_kuhn() {
  std::array<CubeTet, 6> kuhn{};
  std::size_t n = 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      if (a != b) kuhn[n++] = wound({0, 1 << a, 1 << a | 1 << b, 7});
    }
  }
  return kuhn;
}

constexpr auto kFiveTets = make_five();
constexpr auto kKuhnTets = make_kuhn();

// Half the least width, see the header.
double safe_reach(LatticeKind kind, double shear) {
  return kind == LatticeKind::kBcc ? 0.25 / std::sqrt(1 + shear) : 0.288;
}

std::uint64_t rounded_cube_root(double x) {
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(std::cbrt(x))));
}

}  // namespace

std::uint64_t tets_per_cube(LatticeKind kind) {
  switch (kind) {
    case LatticeKind::kFive:
      return 5;
    case LatticeKind::kKuhn:
      return 6;
    case LatticeKind::kBcc:
      return 12;
  }
  return 0;
}

// Tries all sides within a few of the cube root, z as the other two demand, and takes what comes
// closest; of equals the most cubic.
Index3 choose_cubes(LatticeKind kind, std::uint64_t tets) {
  const std::uint64_t per_cube = tets_per_cube(kind);
  const std::uint64_t side =
      rounded_cube_root(static_cast<double>(tets) / static_cast<double>(per_cube));
  const std::uint64_t spread = std::clamp<std::uint64_t>(side / 5, 1, 32);
  const std::uint64_t low = side > spread ? side - spread : 1;
  const std::uint64_t high = side + spread;
  Index3 best{side, side, side};
  const auto distance = [&](const Index3& c) {
    const std::uint64_t n = c[0] * c[1] * c[2] * per_cube;
    return n > tets ? n - tets : tets - n;
  };
  const auto skew = [](const Index3& c) {
    return std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]});
  };
  const auto rank = [&](const Index3& c) { return std::pair(distance(c), skew(c)); };
  for (std::uint64_t x = low; x <= high; ++x) {
    for (std::uint64_t y = x; y <= high; ++y) {
      const std::uint64_t layers = std::max<std::uint64_t>(tets / (per_cube * x * y), 1);
      for (std::uint64_t z : {layers, layers + 1}) {
        const Index3 candidate{x, y, std::clamp(z, low, high)};
        if (rank(candidate) < rank(best)) best = candidate;
      }
    }
  }
  return best;
}

Lattice::Lattice(const LatticeOptions& options)
    : options_(options), per_cube_(tets_per_cube(options.kind)) {
  if (!(options.jitter >= 0 && options.jitter < 1)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("the jitter must be at least 0 and below 1, not {}", options.jitter));
  }
  if (!(options.grading >= 1 && options.grading <= kMaxGrading)) {
    throw Error(ErrorCode::kUsage, fmt::format("the grading must be between 1 and {}, not {}",
                                               kMaxGrading, options.grading));
  }
  double shear = 0;
  cubes_ = corners_ = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::uint64_t n = options.cubes[a];
    if (n == 0) throw Error(ErrorCode::kUsage, "a lattice needs at least one cube along each axis");
    corner_size_[a] = n + 1;
    cubes_ *= n;
    corners_ *= n + 1;
    axes_[a] = make_axis(n, kFeature[a], options.grading);
    shear = std::max(shear, axes_[a].shear);
  }
  middles_ = options.kind == LatticeKind::kBcc ? cubes_ : 0;
  reach_ = safe_reach(options.kind, shear);
}

// The size of a cube at share t of the axis is proportional to 1 + (grading - 1) ((t - f) / m)^2,
// with m the distance from the feature f to the far end; corners are its integral, a cubic, so that
// no library function with its own rounding is needed.
Lattice::Axis Lattice::make_axis(std::uint64_t cubes, double feature, double grading) {
  const double far = std::max(feature, 1 - feature);
  const double weight = (grading - 1) / (3 * far * far);
  const auto integral = [&](double t) {
    const double d = t - feature;
    return t + weight * (d * d * d + feature * feature * feature);
  };
  Axis axis;
  const double whole = integral(1);
  for (std::uint64_t i = 0; i <= cubes; ++i) {
    axis.nodes.push_back(integral(static_cast<double>(i) / static_cast<double>(cubes)) / whole);
  }
  axis.nodes.front() = 0;
  axis.nodes.back() = 1;
  Vector<double> size;
  for (std::uint64_t i = 0; i < cubes; ++i) size.push_back(axis.nodes[i + 1] - axis.nodes[i]);
  axis.corner_reach.assign(cubes + 1, 0);
  for (std::uint64_t i = 1; i < cubes; ++i) {
    const auto [low, high] = std::minmax(size[i - 1], size[i]);
    axis.corner_reach[i] = low;
    axis.shear = std::max(axis.shear, (high - low) / (high + low));
  }
  for (std::uint64_t i = 0; i < cubes; ++i) {
    const std::uint64_t before = i > 0 ? i - 1 : i;
    const std::uint64_t after = std::min(i + 1, cubes - 1);
    axis.middle_reach.push_back(std::min({size[before], size[i], size[after]}));
  }
  axis.smallest = *std::min_element(size.begin(), size.end());
  return axis;
}

Index3 Lattice::unravel(std::uint64_t index, const Index3& size) {
  const std::uint64_t row = index / size[0];
  return {index - row * size[0], row % size[1], row / size[1]};
}

std::uint64_t Lattice::corner(const Index3& at) const {
  return at[0] + corner_size_[0] * (at[1] + corner_size_[1] * at[2]);
}

std::uint64_t Lattice::middle(const Index3& at) const {
  return corners_ + at[0] + options_.cubes[0] * (at[1] + options_.cubes[1] * at[2]);
}

Vec3<double> Lattice::position(std::uint64_t point) const {
  std::array<double, 3> x, reach;
  const bool is_corner = point < corners_;
  const Index3 at =
      is_corner ? unravel(point, corner_size_) : unravel(point - corners_, options_.cubes);
  for (std::size_t a = 0; a < 3; ++a) {
    const Axis& axis = axes_[a];
    x[a] = is_corner ? axis.nodes[at[a]] : 0.5 * (axis.nodes[at[a]] + axis.nodes[at[a] + 1]);
    reach[a] = is_corner ? axis.corner_reach[at[a]] : axis.middle_reach[at[a]];
  }
  if (options_.jitter == 0 || reach[0] == 0 || reach[1] == 0 || reach[2] == 0)
    return {x[0], x[1], x[2]};
  const Vec3<double> d = displacement(point);
  return {x[0] + reach[0] * d.x, x[1] + reach[1] * d.y, x[2] + reach[2] * d.z};
}

// Evenly distributed in the ball of radius jitter * reach_: the first of a point's pseudo-random
// numbers that falls into the ball out of the cube round it. About half do.
Vec3<double> Lattice::displacement(std::uint64_t point) const {
  constexpr int kAttempts = 64;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  constexpr double kScale = 1.0 / (1 << 20);
  std::uint64_t hash = mix(mix(options_.seed) ^ point);
  const double radius = options_.jitter * reach_;
  for (int i = 0; i < kAttempts; ++i) {
    const double x = static_cast<double>(hash & kMask) * kScale - 1;
    const double y = static_cast<double>(hash >> 21 & kMask) * kScale - 1;
    const double z = static_cast<double>(hash >> 42 & kMask) * kScale - 1;
    if (x * x + y * y + z * z <= 1) return {radius * x, radius * y, radius * z};
    hash = mix(hash);
  }
  return {0, 0, 0};
}

Lattice::Corners Lattice::tet(const Index3& cube, std::uint64_t local) const {
  if (options_.kind == LatticeKind::kBcc) return bcc_tet(cube, local);
  const std::uint64_t parity = (cube[0] + cube[1] + cube[2]) & 1;
  const CubeTet& t =
      options_.kind == LatticeKind::kFive ? kFiveTets[parity][local] : kKuhnTets[local];
  const std::uint64_t origin = corner(cube);
  const std::uint64_t layer = corner_size_[0] * corner_size_[1];
  Corners ids;
  for (std::size_t i = 0; i < 4; ++i) {
    ids[i] = origin + static_cast<std::uint64_t>(component(t[i], 0)) +
             static_cast<std::uint64_t>(component(t[i], 1)) * corner_size_[0] +
             static_cast<std::uint64_t>(component(t[i], 2)) * layer;
  }
  return ids;
}

// A cube has two tetrahedra at each of its faces: of the four round an inner face the cube below
// takes the first two, the cube above the others; on the surface they are the halves of the
// pyramid.
Lattice::Corners Lattice::bcc_tet(const Index3& cube, std::uint64_t local) const {
  const std::size_t axis = local / 4;
  const bool above = local / 2 % 2 == 1;  // the face on the far side of the cube
  const std::size_t half = local % 2;
  // The face's corners, anticlockwise as seen from the far end of the axis.
  std::array<std::uint64_t, 4> face;
  for (std::size_t i = 0; i < 4; ++i) {
    Index3 at = cube;
    at[axis] += above ? 1 : 0;
    at[(axis + 1) % 3] += i == 1 || i == 2 ? 1 : 0;
    at[(axis + 2) % 3] += i >= 2 ? 1 : 0;
    face[i] = corner(at);
  }
  const std::uint64_t own = middle(cube);
  if (cube[axis] == (above ? options_.cubes[axis] - 1 : 0)) {
    const std::uint64_t b = face[1 + half], c = face[2 + half];
    return above ? Corners{face[0], c, b, own} : Corners{face[0], b, c, own};
  }
  Index3 next = cube;
  next[axis] += above ? 1 : std::uint64_t(-1);
  const std::uint64_t other = middle(next);
  if (above) return {own, other, face[half], face[half + 1]};
  return {other, own, face[half + 2], face[(half + 3) % 4]};
}

// Corners move by the error in each coordinate, on top of the jitter; in cubes of the smallest
// size.
bool Lattice::survives_rounding(double error) const {
  const double smallest = std::min({axes_[0].smallest, axes_[1].smallest, axes_[2].smallest});
  return smallest > 0 && std::sqrt(3.0) * error / smallest < (1 - options_.jitter) * reach_;
}

}  // namespace tetfusion
