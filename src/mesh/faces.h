// The triangles of a mesh, found from the vertex -> tetrahedra CSR without a table of all faces: a
// face belongs to its smallest vertex, and all its cells are in that vertex's ball.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/geometry.h"
#include "mesh/vertex_tets.h"

namespace tetfusion {

// The corners of the face opposite to a corner, wound so that the right-hand normal points out of a
// tetrahedron of positive volume.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaceCorners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// One cell's side of a face.
struct FaceSide {
  std::uint64_t
      key;  // of the face among its smallest vertex's: middle vertex << 32 | largest vertex
  std::uint32_t entry;  // tet << 2 | corner opposite to the face
  std::uint32_t odd;    // 1 if, seen from outside the cell, the face runs smallest, largest, middle

  VertexId middle() const { return static_cast<VertexId>(key >> 32); }
  VertexId largest() const { return static_cast<VertexId>(key); }
  TetId tet() const { return entry >> 2; }
  std::uint32_t corner() const { return entry & 3; }
};

inline bool names_vertex_twice(const Tet& t) {
  return t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] ||
         t[2] == t[3];
}

// Collects the faces whose smallest vertex is a given one. Keeps its memory from vertex to vertex;
// one a thread.
class FaceMatcher {
 public:
  // Calls visit(std::span<const FaceSide>) for each face, ascending by (middle, largest); the sides
  // ascend by entry. Cells that name a vertex twice have no faces.
  template <class Visit>
  void for_each_face(VertexId v, std::span<const Tet> tets, const VertexTets& vertex_tets,
                     Visit&& visit) {
    collect(v, tets, vertex_tets);
    for (std::size_t begin = 0, end; begin < sides_.size(); begin = end) {
      end = begin + 1;
      while (end < sides_.size() && sides_[end].key == sides_[begin].key) ++end;
      visit(std::span<const FaceSide>(sides_.data() + begin, end - begin));
    }
  }

 private:
  void collect(VertexId v, std::span<const Tet> tets, const VertexTets& vertex_tets);

  Vector<FaceSide> sides_;
};

}  // namespace tetfusion
