// What the two ends of an edge have in common.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernel/live_balls.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from edge to edge. Not thread-safe.
class EdgeLinks {
 public:
  // Do the links of the two ends share the link of the edge, its vertices and edges, and nothing
  // else? Only then cells, faces and edges of the mesh stay apart when the two become one. All
  // tetrahedra of both count that are in this mesh.
  template <class Real>
  bool are_apart(const WorkMesh<Real>& mesh, LiveBalls* balls, VertexId a, VertexId b);

 private:
  bool share_triangle(std::span<const Tet> tets, std::span<const std::uint32_t> ball_a, VertexId a,
                      std::span<const std::uint32_t> ball_b, VertexId b) const;
  void find_other_edges(std::span<const Tet> tets, std::span<const std::uint32_t> ball, VertexId of,
                        std::vector<std::uint64_t>* edges) const;

  // Of the link of the edge.
  std::vector<VertexId> vertices_;
  std::vector<std::uint64_t> edges_;
  std::vector<std::uint64_t> other_edges_of_a_, other_edges_of_b_;
};

}  // namespace tetfusion
