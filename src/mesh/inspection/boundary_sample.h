// How many of a mesh's vertices lie on its boundary, about: found in one pass over the tetrahedra,
// in any order, by looking at a sample of the vertices.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Takes ten bytes a vertex of the sample. A vertex lies inside if each edge of the triangles that
// face it belongs to two of them: what the edges' hashes add up to, bit by bit, is then zero.
class BoundarySample {
 public:
  static constexpr std::uint64_t kVertices = std::uint64_t{1} << 16;

  // Of all vertices, or about so many of them: one of each run of equally many.
  explicit BoundarySample(std::uint64_t points, std::uint64_t vertices = kVertices);

  // From several threads.
  void add(std::span<const Tet> tets);

  // After the last tetrahedron. The shares are of the vertices that tetrahedra use.
  std::uint64_t used_points() const;  // of the mesh, about
  double boundary_share() const;
  std::uint64_t tets() const;  // that were added

 private:
  struct Counts {
    std::uint64_t used = 0;
    std::uint64_t boundary = 0;
  };
  Counts count() const;

  std::uint64_t points_;
  std::uint64_t run_;  // points of each run
  Vector<std::uint64_t> edges_;
  Vector<std::uint8_t> used_;
  std::uint64_t tets_ = 0;
};

}  // namespace tetfusion
