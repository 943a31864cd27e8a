// The boundary surface of a mesh, judged: is it a closed manifold?
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/first_ids.h"
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

// `points` is the number of points of the mesh. At most 2^32 / 3 triangles.
Surface judge_surface(std::size_t points, std::span<const Triangle> triangles);

}  // namespace tetfusion
