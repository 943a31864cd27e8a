// inspect(), for a mesh that is cut into chunks: each chunk is judged on its own, and what lies
// between chunks is judged by InterfaceInspection (interface_inspection.h) from what they report.
// The cost of the second half grows with the interface alone.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"
#include "mesh/inspection/clusters.h"
#include "mesh/inspection/mesh_counts.h"

namespace tetfusion {

// Who has tetrahedra of a point of a chunk.
enum Sharing : std::uint8_t {
  kOwn = 0,         // this chunk alone: the point is free
  kShared = 1,      // other chunks too, or perhaps so: it lies on the interface
  kSharedLast = 2,  // other chunks too, but none that is added later (InterfaceInspection::add)
};

// A chunk: some of the mesh's tetrahedra, and at least the points that they use.
struct ChunkToInspect {
  const Points* points = nullptr;
  std::span<const VertexId> point_ids;         // the mesh's id of each; distinct
  std::span<const std::uint8_t> on_interface;  // one Sharing each. kShared may stand for kOwn and
                                               // kSharedLast, at a cost in time and memory
  std::span<const std::uint64_t> cell_ids;  // the mesh's id of each tetrahedron: "the first cell"
                                            // breaks ties. Empty: they count through the chunks
  bool wants_boundary = false;              // ChunkFindings::boundary
};

// What is known of the interface after one chunk. For InterfaceInspection alone. A point of the
// interface is given by its place in `points`. Bytes: 12 a point, 20 a face of three such points,
// 16 a cell of four, 12 a boundary triangle of one or two: 400 kB for a chunk of 200,000 cells that
// is a piece of a Hilbert curve.
struct InterfaceFindings {
  struct Point {
    VertexId id = 0;
    std::int32_t sum = 0;  // twice the free neighbours, less the cells
    std::uint8_t flags = 0;
    bool is_last = false;  // kSharedLast
    bool is_used = false;  // by a cell of the chunk
  };
  // A cell's side of a face whose three points lie on the interface.
  struct Side {
    std::array<std::uint32_t, 3> face{};  // wound as seen from outside the cell
    VertexId apex = 0;                    // its fourth vertex, by id
    std::uint32_t cluster = 0;            // the cell's, or one of the two below
  };
  static constexpr std::uint32_t kFlat = 0xFFFFFFFFu;  // the cell has no volume
  static constexpr std::uint32_t kPair = 0xFFFFFFFEu;  // both sides of two cells that fit together
  struct Member {                                      // a vertex of a cluster, by id
    std::uint32_t cluster = 0;
    VertexId id = 0;
    auto operator<=>(const Member&) const = default;
  };

  Vector<Point> points;
  Vector<Side> sides;
  Vector<Cluster> clusters;  // those that may go on in other chunks, and what is folded to them
  Vector<Fold> folds;
  Vector<Member> members;                      // of the clusters of at most kMaxBrokenCluster cells
  Vector<std::array<std::uint32_t, 4>> cells;  // all four on the interface; in any order
  Vector<std::array<std::uint32_t, 2>> edges;  // between two points whose common cells have no
                                               // other point on the interface
  Vector<std::array<VertexId, 3>> triangles;   // on the boundary, with points on the interface and
                                               // free ones; by id
  Vector<VertexId> unsound_balls;  // free vertices that are broken for their balls alone; by id
  std::uint64_t cell_count = 0;
  bool cells_have_ids = false;
};

// What one chunk reports. It counts what is certain already; the totals are InterfaceVerdict's.
struct ChunkFindings : MeshCounts {
  // One a point, as in Inspection: boundary, broken and unused ones (VertexFlag bits). Final for
  // points that are not on the interface, but for what InterfaceVerdict::overrides adds. For points
  // on the interface the verdict has them.
  Vector<std::uint8_t> vertex_flags;

  double volume = 0;

  // Boundary triangles with a free point, by ids. Those of three points on the interface are
  // InterfaceVerdict's.
  Vector<std::array<VertexId, 3>> boundary;

  InterfaceFindings interface;
};

// Rewinds the chunk's tetrahedra in place and judges it. Starts no threads. The points of `tets`
// index the chunk's, and must be in range; points and tetrahedra together are countable in 32 bits.
// Fastest where near points have near indices. Takes about 50 bytes a tetrahedron.
ChunkFindings inspect_chunk(const ChunkToInspect& chunk, Vector<Tet>* tets);

}  // namespace tetfusion
