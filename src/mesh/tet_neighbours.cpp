#include "mesh/tet_neighbours.h"

namespace tetfusion {

namespace {

constexpr TetId kUnknown = kNoTet - 1;  // no mesh has so many

}  // namespace

void TetNeighbours::begin(std::size_t vertices, std::span<const Tet> tets) {
  tets_ = tets;
  build_vertex_tets(vertices, tets, &balls_);
  beyond_.assign(4 * tets.size(), kUnknown);
}

TetId TetNeighbours::beyond(TetId tet, std::size_t corner) {
  TetId& known = beyond_[4 * std::size_t{tet} + corner];
  if (known == kUnknown) known = find(tet, corner);
  return known;
}

TetId TetNeighbours::find(TetId tet, std::size_t corner) const {
  const Tet& here = tets_[tet];
  const VertexId a = here[(corner + 1) & 3u], b = here[(corner + 2) & 3u],
                 c = here[(corner + 3) & 3u];
  for (const std::uint32_t entry : balls_.of(a)) {
    const TetId other = entry >> 2;
    if (other != tet && has_corner(tets_[other], b) && has_corner(tets_[other], c)) return other;
  }
  return kNoTet;
}

std::uint64_t TetNeighbours::memory(std::uint64_t tets) {
  // There are four times fewer vertices than tetrahedra, but in odd meshes.
  return tets * (8 * sizeof(std::uint32_t) + sizeof(VertexId) / 4);
}

}  // namespace tetfusion
