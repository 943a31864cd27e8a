// What is odd about a mesh: found once at import, so that what cannot be judged is left alone, and
// by `tetfusion check`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/first_ids.h"
#include "base/vector.h"
#include "mesh/geometry.h"
#include "mesh/inspection/mesh_counts.h"

namespace tetfusion {

// What is known of a vertex, as bits.
enum VertexFlag : std::uint8_t {
  kBoundaryVertex = 1 << 0,  // a face with one cell uses it
  kBrokenVertex = 1 << 1,  // something below is wrong about it or about a cell or face that uses it
  kCarriedVertex = 1 << 2,  // a cell of lower dimension uses it
  kUnusedVertex = 1 << 3,   // no tetrahedron uses it
};

// Kinds of defect. All but the coincident points make their vertices broken.
enum class Defect : std::uint8_t {
  kDegenerate,         // a cell whose volume is 0, or too small for its sign to be certain
  kInverted,           // a cell that lies on the same side of its faces as its neighbours do
  kDuplicate,          // a cell with the same four vertices as an earlier one
  kFoldoverFace,       // a face with two cells, both on the same side of it
  kOverfullFace,       // a face with more than two cells
  kNonmanifoldEdge,    // an edge of the boundary surface whose boundary triangles are not two
  kNonmanifoldVertex,  // a vertex whose ball is not one ball: inner, or its boundary triangles not
                       // one fan
  kCoincidentPoint,    // a point with the coordinates of an earlier one
};
inline constexpr std::size_t kDefectKinds = 8;

// The vertices of inverted cells are broken. But of a cluster of inverted cells (clusters.h) larger
// than this only those of its fold-over faces' cells: inside it is as good as any mesh.
inline constexpr std::uint64_t kMaxBrokenCluster = 4096;

// Ids of cells and points are the geometry's.
struct Inspection : MeshCounts {
  Vector<std::uint8_t> vertex_flags;  // VertexFlag bits

  std::uint64_t coincident_points = 0;
  // The first kFirstIds of each kind, ascending: cells, or for edges, vertices and points a point.
  // A face is given by one of its cells.
  std::array<FirstIds, kDefectKinds> samples;
  const FirstIds& first(Defect kind) const { return samples[static_cast<std::size_t>(kind)]; }

  std::uint64_t surface_components = 0;  // of the boundary, connected by vertices
  std::uint64_t components = 0;          // of the cells, connected by faces
  std::uint64_t unused_points = 0;

  double volume = 0;              // sum over all cells, after rewinding
  std::array<double, 3> lower{};  // the bounding box of all points
  std::array<double, 3> upper{};

  // Wound so that the right-hand normal points out of the mesh; each begins with its smallest
  // vertex, and they ascend by that. A degenerate cell's are wound at random.
  Vector<std::array<VertexId, 3>> boundary_triangles;
};

// Rewinds, in place, the cells that are wound the other way, then judges the mesh. All ids must be
// in range, and points and tetrahedra together countable in 32 bits. The result does not depend on
// the number of threads.
Inspection inspect(Geometry& geometry);

}  // namespace tetfusion
