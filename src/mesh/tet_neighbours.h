// What is on the other side of a tetrahedron's faces, looked for when somebody asks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"
#include "mesh/vertex_tets.h"

namespace tetfusion {

// Begin with a mesh, and ask; keeps its memory; one a thread.
class TetNeighbours {
 public:
  // As for build_vertex_tets(). The tetrahedra outlive this, and do not change.
  void begin(std::size_t vertices, std::span<const Tet> tets);

  // Beyond the face without that corner; kNoTet at a boundary, and one of them where there are
  // several.
  TetId beyond(TetId tet, std::size_t corner);

  const VertexTets& balls() const { return balls_; }

  // Bytes that takes for so many tetrahedra.
  static std::uint64_t memory(std::uint64_t tets);

 private:
  TetId find(TetId tet, std::size_t corner) const;

  std::span<const Tet> tets_;
  VertexTets balls_;
  Vector<TetId> beyond_;  // each corner, where somebody has asked already; else kUnknown
};

}  // namespace tetfusion
