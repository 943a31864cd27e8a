#include "mesh/faces.h"

namespace tetfusion {

void FaceMatcher::collect(VertexId v, std::span<const Tet> tets, const VertexTets& vertex_tets) {
  sides_.clear();
  for (const std::uint32_t entry : vertex_tets.of(v)) {
    const Tet& t = tets[entry >> 2];
    if (names_vertex_twice(t)) continue;
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      if (corner == (entry & 3)) continue;
      const auto& face = kFaceCorners[corner];
      std::array<VertexId, 3> f{t[face[0]], t[face[1]], t[face[2]]};
      // Turn the face until it begins with v.
      if (f[1] == v) f = {f[1], f[2], f[0]};
      if (f[2] == v) f = {f[2], f[0], f[1]};
      if (f[1] < v || f[2] < v) continue;
      const bool odd = f[1] > f[2];
      const std::uint64_t middle = odd ? f[2] : f[1];
      const std::uint64_t largest = odd ? f[1] : f[2];
      sides_.push_back({middle << 32 | largest, (entry & ~3u) | corner, odd ? 1u : 0u});
    }
  }
  std::sort(sides_.begin(), sides_.end(), [](const FaceSide& a, const FaceSide& b) {
    return a.key != b.key ? a.key < b.key : a.entry < b.entry;
  });
}

}  // namespace tetfusion
