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
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tetfusion {

// Where things lie in a quadric.
inline constexpr std::size_t kQuadricA = 0;  // xx, xy, xz, yy, yz, zz
inline constexpr std::size_t kQuadricL = 6;
inline constexpr std::size_t kQuadricC = 9;
inline constexpr std::size_t kQuadricW = 10;
inline constexpr std::size_t kQuadricFields = 11;  // b and e of the first field

// Numbers in a quadric of so many fields.
constexpr std::size_t quadric_size(std::size_t width) { return kQuadricFields + 4 * width; }

using Offset = std::array<float, 3>;

inline float dot(const float* a, const Offset& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// A times u.
inline Offset times(const float* a, const Offset& u) {
  return {a[0] * u[0] + a[1] * u[1] + a[2] * u[2], a[1] * u[0] + a[3] * u[1] + a[4] * u[2],
          a[2] * u[0] + a[4] * u[1] + a[5] * u[2]};
}

// Adds a tetrahedron of this weight, in which the fields have these gradients (three numbers each),
// to the quadric of one of its vertices.
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

// Adds `from` to `to`, whose vertex lies at the offset u and has values larger by t.
inline void add_shifted(const float* from, const Offset& u, const float* t, std::size_t width,
                        float* to) {
  const float w = from[kQuadricW];
  const Offset au = times(from, u);
  Offset l{from[6] + au[0], from[7] + au[1], from[8] + au[2]};
  float c = from[kQuadricC] + dot(from + kQuadricL, u) + dot(l.data(), u);
  for (std::size_t k = 0; k < width; ++k) {
    const float* field = from + kQuadricFields + 4 * k;
    float* sum = to + kQuadricFields + 4 * k;
    const float at_u = field[3] + dot(field, u);
    for (std::size_t i = 0; i < 3; ++i) {
      l[i] -= t[k] * field[i];
      sum[i] += field[i];
    }
    sum[3] += at_u - w * t[k];
    c += t[k] * (w * t[k] - 2 * at_u);
  }
  for (std::size_t i = 0; i < 6; ++i) to[i] += from[i];
  for (std::size_t i = 0; i < 3; ++i) to[kQuadricL + i] += l[i];
  to[kQuadricC] += c;
  to[kQuadricW] += w;
}

// The quadric when each field takes its best value: u'Mu + 2 n.u + k.
struct Reduced {
  std::array<float, 6> m;
  Offset n;
  float k;
};

inline Reduced reduce(const float* q, std::size_t width) {
  Reduced r{{q[0], q[1], q[2], q[3], q[4], q[5]}, {q[6], q[7], q[8]}, q[kQuadricC]};
  const float inverse = q[kQuadricW] > 0 ? 1 / q[kQuadricW] : 0;
  for (std::size_t i = 0; i < width; ++i) {
    const float* b = q + kQuadricFields + 4 * i;
    const float x = b[0] * inverse, y = b[1] * inverse, z = b[2] * inverse;
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
inline float value_at(const Reduced& r, const Offset& u) {
  const Offset mu = times(r.m.data(), u);
  return dot(mu.data(), u) + 2 * dot(r.n.data(), u) + r.k;
}

// Where it is least, or nearly: a share `pull` of its mean curvature draws the position towards
// `home`, as along some directions nothing else may tell where to go, and it goes no further from
// there than the root of `reach_squared`.
inline Offset best_position(const Reduced& r, const Offset& home, float pull, float reach_squared) {
  const Offset mh = times(r.m.data(), home);
  const Offset g{mh[0] + r.n[0], mh[1] + r.n[1], mh[2] + r.n[2]};
  const float rho = pull * (r.m[0] + r.m[3] + r.m[5]);
  const float xx = r.m[0] + rho, yy = r.m[3] + rho, zz = r.m[5] + rho;
  const float xy = r.m[1], xz = r.m[2], yz = r.m[4];
  const float cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  const float det = xx * cxx + xy * cxy + xz * cxz;
  if (!(det > 0)) return home;
  const float cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
  const float scale = -1 / det;
  const Offset step{scale * (cxx * g[0] + cxy * g[1] + cxz * g[2]),
                    scale * (cxy * g[0] + cyy * g[1] + cyz * g[2]),
                    scale * (cxz * g[0] + cyz * g[1] + czz * g[2])};
  const float square = dot(step.data(), step);
  if (!(square < std::numeric_limits<float>::infinity())) return home;
  const float shorten = square > reach_squared ? std::sqrt(reach_squared / square) : 1;
  return {home[0] + shorten * step[0], home[1] + shorten * step[1], home[2] + shorten * step[2]};
}

// The best value of field k at u, as an offset from the vertex's.
inline float best_value(const float* q, std::size_t k, const Offset& u) {
  const float* b = q + kQuadricFields + 4 * k;
  return q[kQuadricW] > 0 ? (b[3] + dot(b, u)) / q[kQuadricW] : 0;
}

}  // namespace tetfusion
