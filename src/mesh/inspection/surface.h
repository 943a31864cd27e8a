// The boundary surface of a mesh, judged: is it a closed manifold?
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/first_ids.h"
#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

using Triangle = std::array<VertexId, 3>;

struct Surface {
  std::uint64_t vertices = 0;
  std::uint64_t edges = 0;
  std::uint64_t components = 0;  // connected by vertices
  std::uint64_t nonmanifold_edges = 0;
  FirstIds nonmanifold_edge_samples;  // the smaller vertex of each
  Vector<VertexId>
      nonmanifold_vertices;  // ascending: the triangles round them are not one closed fan
  // Triangles round vertex v: offsets[v + 1] - offsets[v].
  Vector<std::uint32_t> offsets;
};

// The link of a sound vertex, the surface of its ball, is a sphere, or a disc for a boundary
// vertex: its Euler number is 2 or 1. With n cells and b boundary triangles round the vertex the
// link has n triangles and (3 n + b) / 2 edges, as long as no face has more than two cells; its
// vertices are the vertex's neighbours. Returns what twice their number less n then is.
inline std::int32_t sum_of_sound_ball(std::int32_t boundary_triangles) {
  return 2 * (boundary_triangles > 0 ? 1 : 2) + boundary_triangles;
}

// `points` is the number of points of the mesh. At most 2^32 / 3 triangles.
Surface judge_surface(std::size_t points, std::span<const Triangle> triangles);

// The part of a surface that lies in a piece of a mesh.
struct SurfacePart {
  std::span<const std::uint8_t> foreign;  // one a point; 1: others judge the vertex
  bool mixed_edges = false;  // whether edges between a vertex of ours and a foreign one are ours
};

// Judges what is ours: vertices that are not foreign, with all their triangles, and edges between
// two of those, or as the part says. Starts no threads; does not count components.
Surface judge_surface_part(const SurfacePart& part, std::span<const Triangle> triangles);

}  // namespace tetfusion
