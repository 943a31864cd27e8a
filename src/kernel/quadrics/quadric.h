// Vertex quadrics of the steering fields: how far a vertex's value would be from the fields of the
// original mesh, as linear functions of the tetrahedra round it, in the mean of squares.
//
// A tetrahedron T with the weight V (its volume, in any unit) and the linear function g.x + d
// contributes, at each of its vertices, V (g.u + e - t)^2, where u is the offset of a position from
// the vertex, t the offset of a value from the vertex's, and e the function's deviation there (none
// at first). A sum of these, for `width` fields whose squares add up, is
//
//   u'Au + 2 l.u + c - 2 sum_k t_k (b_k.u + e_k) + w sum_k t_k^2
//
// with A = sum V g g', l = sum V e g, c = sum V e^2 over all fields, w = sum V, and for each field
// b = sum V g, e = sum V e: eleven numbers, and four a field. They are about their own vertex, so
// that single precision loses nothing far from the origin; adding two means shifting one.
//
// Functions over F work on one quadric (float), or on several side by side (Lanes).
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "base/lanes.h"

namespace tetfusion {

// Where things lie in a quadric.
inline constexpr std::size_t kQuadricA = 0;  // xx, xy, xz, yy, yz, zz
inline constexpr std::size_t kQuadricL = 6;
inline constexpr std::size_t kQuadricC = 9;
inline constexpr std::size_t kQuadricW = 10;
inline constexpr std::size_t kQuadricFields = 11;  // b and e of the first field

// Numbers in a quadric of so many fields.
constexpr std::size_t quadric_size(std::size_t width) { return kQuadricFields + 4 * width; }

template <class F>
using OffsetOf = std::array<F, 3>;
using Offset = OffsetOf<float>;

template <class F>
inline F dot(const F* a, const OffsetOf<F>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// A times u.
template <class F>
inline OffsetOf<F> times(const F* a, const OffsetOf<F>& u) {
  return {a[0] * u[0] + a[1] * u[1] + a[2] * u[2], a[1] * u[0] + a[3] * u[1] + a[4] * u[2],
          a[2] * u[0] + a[4] * u[1] + a[5] * u[2]};
}

// Adds a tetrahedron of this weight, in which the fields have these gradients (three numbers each),
// to a quadric that is to be one of its vertices', or is added to theirs.
inline void add_tetrahedron(float weight, const float* gradients, std::size_t width, float* q) {
  q[kQuadricW] += weight;
  for (std::size_t k = 0; k < width; ++k) {
    const float* g = gradients + 3 * k;
    float* field = q + kQuadricFields + 4 * k;
    const float x = weight * g[0], y = weight * g[1], z = weight * g[2];
    q[0] += x * g[0];
    q[1] += x * g[1];
    q[2] += x * g[2];
    q[3] += y * g[1];
    q[4] += y * g[2];
    q[5] += z * g[2];
    field[0] += x;
    field[1] += y;
    field[2] += z;
  }
}

// Takes the gradients of its tetrahedra as uncertain, with this variance along each direction, in
// the quadric of a vertex that has not fused yet. Where fields are linear that makes far vertices
// dearer than near ones, and they meet in the middle of what they stand for: fewer fusions are
// refused for the shapes that would come. (Isotropic noise as in Trettner and Kobbelt, Fast and
// Robust QEF Minimization using Probabilistic Quadrics, 2020.)
inline void add_gradient_variance(float variance, float* q) {
  for (const std::size_t i : {0, 3, 5}) q[kQuadricA + i] += variance * q[kQuadricW];
}

// Adds `from` to `to`, whose vertex lies at the offset u and has values larger by t.
template <class F>
inline void add_shifted(const F* from, const OffsetOf<F>& u, const std::type_identity_t<F>* t,
                        std::size_t width, F* to) {
  const F w = from[kQuadricW];
  const OffsetOf<F> au = times(from, u);
  OffsetOf<F> l{from[6] + au[0], from[7] + au[1], from[8] + au[2]};
  F c = from[kQuadricC] + dot(from + kQuadricL, u) + dot(l.data(), u);
  for (std::size_t k = 0; k < width; ++k) {
    const F* field = from + kQuadricFields + 4 * k;
    F* sum = to + kQuadricFields + 4 * k;
    const F at_u = field[3] + dot(field, u);
    for (std::size_t i = 0; i < 3; ++i) {
      l[i] -= t[k] * field[i];
      sum[i] += field[i];
    }
    sum[3] += at_u - w * t[k];
    c += t[k] * (w * t[k] - 2.0F * at_u);
  }
  for (std::size_t i = 0; i < 6; ++i) to[i] += from[i];
  for (std::size_t i = 0; i < 3; ++i) to[kQuadricL + i] += l[i];
  to[kQuadricC] += c;
  to[kQuadricW] += w;
}

// The quadric when each field takes its best value: u'Mu + 2 n.u + k.
template <class F>
struct ReducedOf {
  std::array<F, 6> m;
  OffsetOf<F> n;
  F k;
};
using Reduced = ReducedOf<float>;

template <class F>
inline ReducedOf<F> reduce(const F* q, std::size_t width) {
  ReducedOf<F> r{{q[0], q[1], q[2], q[3], q[4], q[5]}, {q[6], q[7], q[8]}, q[kQuadricC]};
  const F inverse = select(q[kQuadricW] > 0.0F, 1.0F / q[kQuadricW], F{});
  for (std::size_t i = 0; i < width; ++i) {
    const F* b = q + kQuadricFields + 4 * i;
    const F x = b[0] * inverse, y = b[1] * inverse, z = b[2] * inverse;
    r.m[0] -= x * b[0];
    r.m[1] -= x * b[1];
    r.m[2] -= x * b[2];
    r.m[3] -= y * b[1];
    r.m[4] -= y * b[2];
    r.m[5] -= z * b[2];
    r.n[0] -= x * b[3];
    r.n[1] -= y * b[3];
    r.n[2] -= z * b[3];
    r.k -= b[3] * inverse * b[3];
  }
  return r;
}

// Its value at u.
template <class F>
inline F value_at(const ReducedOf<F>& r, const OffsetOf<F>& u) {
  const OffsetOf<F> mu = times(r.m.data(), u);
  return dot(mu.data(), u) + 2.0F * dot(r.n.data(), u) + r.k;
}

// The products of two of its axes each, as a symmetric matrix: the inverse times the determinant.
template <class F>
inline std::array<F, 6> adjugate(const std::array<F, 6>& m) {
  return {m[3] * m[5] - m[4] * m[4], m[2] * m[4] - m[1] * m[5], m[1] * m[4] - m[2] * m[3],
          m[0] * m[5] - m[2] * m[2], m[1] * m[2] - m[0] * m[4], m[0] * m[3] - m[1] * m[1]};
}

// The step that goes so far along a direction of unit length and, but for a share `pull` of the
// mean curvature, costs least on the way: where it goes aside costs nothing, it does.
inline Offset cheapest_step(const Reduced& r, const Offset& direction, float distance, float pull) {
  const float unit = normalizer(r.m[0] + r.m[3] + r.m[5]);
  std::array<float, 6> m = r.m;
  for (float& x : m) x *= unit;
  const float rho = pull * (m[0] + m[3] + m[5]);
  for (const std::size_t i : {0, 3, 5}) m[i] += rho;
  Offset step = times(adjugate(m).data(), direction);
  const float along = dot(step.data(), direction);
  if (!(along > 0 && along < std::numeric_limits<float>::infinity())) step = direction;
  const float scale = distance / dot(step.data(), direction);
  for (float& x : step) x *= scale;
  return step;
}

// Where it is least, or nearly: a share `pull` of its mean curvature draws the position towards
// `home`, as along some directions nothing else may tell where to go, and it goes no further from
// there than the root of `reach_squared`.
template <class F>
inline OffsetOf<F> best_position(const ReducedOf<F>& r, const OffsetOf<F>& home, float pull,
                                 std::type_identity_t<F> reach_squared) {
  // In a unit of their own: where fields are flat, products of three would be too small for numbers
  // of full precision, which many processors take a hundred times as long for.
  const F unit = normalizer(r.m[0] + r.m[3] + r.m[5]);
  std::array<F, 6> m = r.m;
  for (F& x : m) x *= unit;
  const OffsetOf<F> mh = times(m.data(), home);
  const OffsetOf<F> g{mh[0] + unit * r.n[0], mh[1] + unit * r.n[1], mh[2] + unit * r.n[2]};
  const F rho = pull * (m[0] + m[3] + m[5]);
  for (const std::size_t i : {0, 3, 5}) m[i] += rho;
  const std::array<F, 6> c = adjugate(m);
  const F det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
  const F scale = -1.0F / det;
  const OffsetOf<F> cg = times(c.data(), g);
  const OffsetOf<F> step{scale * cg[0], scale * cg[1], scale * cg[2]};
  const F square = dot(step.data(), step);
  const auto is_known = (det > 0.0F) & (square < std::numeric_limits<float>::infinity());
  const F shorten = select(square > reach_squared, square_root(reach_squared / square), F{} + 1.0F);
  OffsetOf<F> best = home;
  for (std::size_t i = 0; i < 3; ++i) {
    best[i] = select(is_known, home[i] + shorten * step[i], home[i]);
  }
  return best;
}

// The best value of field k at u, as an offset from the vertex's.
inline float best_value(const float* q, std::size_t k, const Offset& u) {
  const float* b = q + kQuadricFields + 4 * k;
  return q[kQuadricW] > 0 ? (b[3] + dot(b, u)) / q[kQuadricW] : 0;
}

}  // namespace tetfusion
