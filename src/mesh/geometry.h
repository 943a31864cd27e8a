// A tetrahedral mesh without its arrays: points, tetrahedra, and the cells of lower dimension that
// ride along. Vertex ids are 32 bits wide: a mesh in memory has fewer than 2^32 - 1 points and
// fewer than 2^30 tetrahedra (kMaxTets).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "base/vector.h"
#include "mesh/data_array.h"

namespace tetfusion {

template <class Real>
struct Vec3 {
  Real x, y, z;
};

using VertexId = std::uint32_t;
using TetId = std::uint32_t;
inline constexpr VertexId kNoVertex = 0xFFFFFFFFu;
inline constexpr TetId kNoTet = 0xFFFFFFFFu;
// Four corners a tetrahedron must still be countable in 32 bits.
inline constexpr std::uint64_t kMaxTets = (std::uint64_t{1} << 30) - 1;
inline constexpr std::uint64_t kMaxPoints = 0xFFFFFFFEu;

// Vertex ids of one tetrahedron. Positive volume means VTK's winding: vertex 3 lies on the side of
// triangle (0, 1, 2) towards which its right-hand normal points.
using Tet = std::array<VertexId, 4>;

inline bool has_corner(const Tet& tet, VertexId v) {
  return tet[0] == v || tet[1] == v || tet[2] == v || tet[3] == v;
}

// One number an edge, whichever end comes first.
inline std::uint64_t edge_key(VertexId a, VertexId b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

// Coordinates keep the type of the file they came from.
using Points = std::variant<Vector<Vec3<float>>, Vector<Vec3<double>>>;
std::uint64_t point_count(const Points& points);
ValueType point_type(const Points& points);

// Vertices, lines, triangles (VTK cell types 1, 3, 5): they carry boundary conditions.
struct LowerCells {
  Vector<std::uint8_t> types;     // VTK cell type
  Vector<std::uint64_t> offsets;  // size() + 1 entries, offsets[0] == 0; empty when size() == 0
  Vector<VertexId> connectivity;
  std::uint64_t size() const { return types.size(); }
  std::span<const VertexId> corners(std::uint64_t cell) const {
    return std::span(connectivity).subspan(offsets[cell], offsets[cell + 1] - offsets[cell]);
  }

  void add(std::uint8_t type, std::span<const VertexId> corners);
  void add(const LowerCells& others);
};

// Between values that copies of points had and those that were taken in their place.
struct LargestDifference {
  std::size_t array = 0;  // its place among the mesh's point arrays; npos where it is none of them
  double share = 0;       // of that array's range; 0: there is none, or none of finite values
};

struct Geometry {
  Points points;
  Vector<Tet> tets;
  LowerCells lower;

  // Where things came from, as indices into the input's points and cells counted through all
  // pieces: the rows of the arrays that MeshSource::read_array returns. Empty means the identity.
  Vector<std::uint64_t> point_source;
  Vector<std::uint64_t> tet_source;
  Vector<std::uint64_t> lower_source;

  // What reading left out.
  std::uint64_t unused_points = 0;     // used by no cell, dropped
  std::uint64_t merged_points = 0;     // copies of others, merged into the first one
  std::uint64_t differing_points = 0;  // of these, with another value in some array than was taken
  LargestDifference largest_difference;
  std::uint64_t ghost_cells = 0;  // another piece's cells, dropped
};

}  // namespace tetfusion
