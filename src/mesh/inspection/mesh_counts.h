// What is wrong with a mesh, and how large its boundary is: of the whole, a chunk, or what lies
// between chunks.
#pragma once

#include <cstdint>

namespace tetfusion {

struct MeshCounts {
  std::uint64_t rewound = 0;  // cells that were wound the other way and are not inverted; no defect
  std::uint64_t degenerate = 0;
  std::uint64_t inverted = 0;
  std::uint64_t duplicate_tets = 0;
  std::uint64_t foldover_faces = 0;
  std::uint64_t overfull_faces = 0;
  std::uint64_t nonmanifold_edges = 0;
  std::uint64_t nonmanifold_vertices = 0;
  std::uint64_t boundary_faces = 0;  // triangles
  std::uint64_t boundary_edges = 0;
  std::uint64_t boundary_vertices = 0;

  std::int64_t surface_euler() const {  // vertices - edges + triangles of the boundary
    return static_cast<std::int64_t>(boundary_vertices + boundary_faces) -
           static_cast<std::int64_t>(boundary_edges);
  }

  MeshCounts& operator+=(const MeshCounts& other) {
    rewound += other.rewound;
    degenerate += other.degenerate;
    inverted += other.inverted;
    duplicate_tets += other.duplicate_tets;
    foldover_faces += other.foldover_faces;
    overfull_faces += other.overfull_faces;
    nonmanifold_edges += other.nonmanifold_edges;
    nonmanifold_vertices += other.nonmanifold_vertices;
    boundary_faces += other.boundary_faces;
    boundary_edges += other.boundary_edges;
    boundary_vertices += other.boundary_vertices;
    return *this;
  }
};

}  // namespace tetfusion
