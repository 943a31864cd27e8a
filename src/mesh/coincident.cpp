#include "mesh/coincident.h"

#include <bit>
#include <cstdint>

namespace tetfusion {

namespace {

template <class Real>
std::uint64_t hash_point(const Vec3<Real>& p) {
  std::uint64_t hash = 0;
  for (const double x : {double{p.x}, double{p.y}, double{p.z}}) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9E3779B97F4A7C15u;  // -0 becomes 0
    hash ^= hash >> 32;
  }
  return hash;
}

template <class Real>
Vector<std::pair<VertexId, VertexId>> find(const Vector<Vec3<Real>>& points) {
  Vector<std::pair<VertexId, VertexId>> found;
  const std::size_t mask = std::bit_ceil(2 * points.size() + 1) - 1;
  Vector<VertexId> slots(mask + 1, kNoVertex);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Vec3<Real>& p = points[v];
    for (std::size_t i = hash_point(p);; ++i) {
      VertexId& slot = slots[i & mask];
      if (slot == kNoVertex) {
        slot = static_cast<VertexId>(v);
        break;
      }
      const Vec3<Real>& q = points[slot];
      if (p.x == q.x && p.y == q.y && p.z == q.z) {
        found.push_back({static_cast<VertexId>(v), slot});
        break;
      }
    }
  }
  return found;
}

}  // namespace

Vector<std::pair<VertexId, VertexId>> coincident_points(const Points& points) {
  return std::visit([](const auto& p) { return find(p); }, points);
}

}  // namespace tetfusion
