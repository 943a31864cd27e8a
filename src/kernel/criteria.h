// The criteria of TetFusion (Chopra & Meyer 2002, sections 3.2-3.5), and a bound on volumes, as
// pure functions: true when the fusion must be refused. And what passes count, and go by.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "mesh/predicates.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Why a tetrahedron did not become prey in a pass, or with fuse why a vertex did not join another
// one in a round. Each candidate is counted under the first that applies.
enum class Reject : std::uint8_t {
  kBoundary,   // the boundary rule
  kLocked,     // a vertex that must stay for another reason
  kScalar,     // a steering field would deviate too far
  kFlip,       // an affected tetrahedron would turn over, or it cannot be told that it would not
  kStretch,    // an affected tetrahedron's base normal would grow too long
  kAspect,     // an affected tetrahedron's edge lengths would become too unequal
  kInterface,  // a vertex on the interface of two chunks, which another round will cut elsewhere
  kQuota,      // the pass has removed what the goal allows up to here
  kError,      // it would cost more than the round allows
  kQuality,    // an affected tetrahedron would be worse than the floor, or its cavity's grade
  kSurface,    // the surface, or one between regions, would move too far, or be torn or pinched
  kDeviation,  // a steering field would deviate too far at a point of the original
  kIntegral,   // the integral of a field would change, or a value would leave its cavity's range
  kVolume,     // an affected tetrahedron would become too large
};
inline constexpr std::size_t kRejectReasons = 14;
inline constexpr std::array<std::string_view, kRejectReasons> kRejectNames{
    "boundary", "locked", "scalar",  "flip",    "stretch",   "aspect",   "interface",
    "quota",    "error",  "quality", "surface", "deviation", "integral", "volume"};

// What a pass, or all passes of a round, did.
struct PassStatistics {
  std::uint64_t tets_before = 0;
  std::uint64_t tets_after = 0;
  std::uint64_t fused = 0;  // fusions
  std::uint64_t labelled =
      0;  // tetrahedra passed over because this pass had affected or deleted them
  std::array<std::uint64_t, kRejectReasons> rejected{};

  std::uint64_t removed() const { return tets_before - tets_after; }
};

// What may become of what a fusion moves; infinity is off.
struct PaperLimits {
  static constexpr double kOff = std::numeric_limits<double>::infinity();
  double scalar_tolerance = kOff;  // share of the range
  double stretch_factor = kOff;
  double aspect_ratio = kOff;
  double max_volume = kOff;  // of a tetrahedron

  static bool is_on(double limit) { return limit < kOff; }
  bool judge_shapes() const {
    return is_on(stretch_factor) || is_on(aspect_ratio) || is_on(max_volume);
  }
};

inline constexpr std::uint32_t kNoColumn = 0xFFFFFFFFu;

// A field that steers: its values are components [first, first + count) of a vertex's steering
// tuple.
struct SteeringField {
  std::uint32_t first = 0;
  std::uint32_t count = 1;
  // Over the original's points that tetrahedra use; a vector's is the diagonal of its component
  // box. > 0
  double range = 0;
  // Share of the range: with the paper's operation in place of the pass's scalar tolerance, with
  // Method::kFuse of what is allowed at points of the original.
  std::optional<double> tolerance;
  // The point column that these are the values of, times 2^exponent; none: a cell array's means.
  std::uint32_t column = kNoColumn;
  std::int32_t exponent = 0;
};

// Corner c of a tetrahedron and the three others, in an order that keeps the sign of its volume.
inline constexpr std::array<std::array<std::uint8_t, 4>, 4> kCornerFirst{
    {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}}};

template <class Real>
std::array<Vec3<Real>, 4> corners(const Vector<Vec3<Real>>& positions, const Tet& t) {
  return {positions[t[0]], positions[t[1]], positions[t[2]], positions[t[3]]};
}

// Quarters first: the sum of large values could overflow. Exact scaling, so that otherwise nothing
// changes.
inline double mean_of_four(double a, double b, double c, double d) {
  return (0.25 * a + 0.25 * b) + (0.25 * c + 0.25 * d);
}

// Flipping: does the tetrahedron with corners x, b, c, d fail to have certainly positive volume?
template <class Real>
inline bool flips(const Vec3<Real>& x, const Vec3<Real>& b, const Vec3<Real>& c,
                  const Vec3<Real>& d) {
  return determinant(x, b, c, d).sign() <= 0;
}

// The same for a tetrahedron one of whose corners comes to x, in the order of its corners: how sure
// the sign is depends on which is the first, and whoever reads the mesh goes by that.
template <class Real>
inline bool flips_as_written(const Vec3<Real>& x, std::uint32_t corner, const Tet& tet,
                             const Vector<Vec3<Real>>& positions) {
  std::array<Vec3<Real>, 4> p = corners(positions, tet);
  p[corner] = x;
  return flips(p[0], p[1], p[2], p[3]);
}

// Scalar: is a steering value at one of the prey's vertices further than its tolerance from the
// mean of the four? `values` are the four vertices' tuples, `mean` their mean; distances of vectors
// are Euclidean.
inline bool deviates(std::span<const SteeringField> fields, double scalar_tolerance,
                     const std::array<const double*, 4>& values, const double* mean) {
  for (const SteeringField& f : fields) {
    const double limit = f.tolerance.value_or(scalar_tolerance) * f.range;
    for (const double* v : values) {
      double square = 0;
      for (std::uint32_t k = f.first; k < f.first + f.count; ++k) {
        square += (v[k] - mean[k]) * (v[k] - mean[k]);
      }
      if (!(std::sqrt(square) < limit)) return true;
    }
  }
  return false;
}

// Squared length, times 144, of the base normal of corner c: from the centre of the base triangle
// to the barycenter of the tetrahedron, which is a quarter of the way to the corner. Three times
// the corner minus the sum of the base's is twelve times that vector; ratios need no division.
template <class Real>
inline double base_normal_squared(const std::array<Vec3<Real>, 4>& p, int c) {
  const auto& order = kCornerFirst[static_cast<std::size_t>(c)];
  const Vec3<Real>&a = p[order[0]], &u = p[order[1]], &v = p[order[2]], &w = p[order[3]];
  const double x = 3 * double{a.x} - (double{u.x} + v.x + w.x);
  const double y = 3 * double{a.y} - (double{u.y} + v.y + w.y);
  const double z = 3 * double{a.z} - (double{u.z} + v.z + w.z);
  return x * x + y * y + z * z;
}

// Stretch: is the normal stretch ratio S_N of corner c, after over before, not below the factor?
// `before` are the tetrahedron's corners in the last macroLoD.
template <class Real>
inline bool stretches(const std::array<Vec3<Real>, 4>& before,
                      const std::array<Vec3<Real>, 4>& after, int c, double stretch_factor) {
  return !(base_normal_squared(after, c) <
           stretch_factor * stretch_factor * base_normal_squared(before, c));
}

// Longest over shortest edge, squared.
template <class Real>
inline double edge_ratio_squared(const std::array<Vec3<Real>, 4>& p) {
  double longest = 0;
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double x = double{p[j].x} - p[i].x;
      const double y = double{p[j].y} - p[i].y;
      const double z = double{p[j].z} - p[i].z;
      const double square = x * x + y * y + z * z;
      longest = std::max(longest, square);
      shortest = std::min(shortest, square);
    }
  }
  return longest / shortest;
}

// Aspect ratio: does the tetrahedron exceed the limit and get worse?
template <class Real>
inline bool distorts(const std::array<Vec3<Real>, 4>& before,
                     const std::array<Vec3<Real>, 4>& after, double aspect_ratio) {
  const double ratio = edge_ratio_squared(after);
  return ratio > aspect_ratio * aspect_ratio && !(ratio <= edge_ratio_squared(before));
}

// Volume: does the tetrahedron exceed the limit and grow?
template <class Real>
inline bool outgrows(const std::array<Vec3<Real>, 4>& before,
                     const std::array<Vec3<Real>, 4>& after, double max_volume) {
  const auto volume = [](const std::array<Vec3<Real>, 4>& p) {
    return std::abs(determinant(p[0], p[1], p[2], p[3]).value) / 6;
  };
  const double grown = volume(after);
  return grown > max_volume && !(grown <= volume(before));
}

// The first of stretch, aspect ratio and volume that speaks against moving the corners `affected`
// (tet << 2 | corner) to the position; stretches_too_far(entry, now, after) is asked where there is
// a stretch factor.
template <class Real, class StretchesTooFar>
std::optional<Reject> judge_shapes(const PaperLimits& limits, const WorkMesh<Real>& mesh,
                                   std::span<const std::uint32_t> affected,
                                   const Vec3<Real>& position,
                                   const StretchesTooFar& stretches_too_far) {
  if (!limits.judge_shapes()) return std::nullopt;
  for (const std::uint32_t entry : affected) {
    const auto now = corners(mesh.positions, mesh.tets[entry >> 2]);
    auto after = now;
    after[entry & 3u] = position;
    if (PaperLimits::is_on(limits.stretch_factor) && stretches_too_far(entry, now, after)) {
      return Reject::kStretch;
    }
    if (PaperLimits::is_on(limits.aspect_ratio) && distorts(now, after, limits.aspect_ratio)) {
      return Reject::kAspect;
    }
    if (PaperLimits::is_on(limits.max_volume) && outgrows(now, after, limits.max_volume)) {
      return Reject::kVolume;
    }
  }
  return std::nullopt;
}

}  // namespace tetfusion
