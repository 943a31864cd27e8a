// A macroLoD between two rounds: cut into chunks, or in one piece where it is no larger than one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "io/store/piece_store.h"
#include "kernel/costs.h"
#include "kernel/sheets/facing_grid.h"
#include "mesh/inspection/chunk_inspection.h"
#include "mesh/work_mesh.h"
#include "partition/curve_cut.h"
#include "partition/interface_table.h"

namespace tetfusion {

// What a chunk's judge wants to know of a vertex with these marks.
inline std::uint8_t sharing_of(std::uint8_t marks) {
  if ((marks & kOnInterface) == 0) return kOwn;
  return is_counted_elsewhere(marks) ? kShared : kSharedLast;
}

// Judges a chunk whose vertices say by their marks how it shares them. Rewinds tetrahedra, and
// leaves all else as it is.
template <class Real>
ChunkFindings inspect_as_marked(WorkMesh<Real>* mesh, bool wants_boundary) {
  Vector<std::uint8_t> sharing(mesh->vertex_count());
  for (std::size_t v = 0; v < sharing.size(); ++v) sharing[v] = sharing_of(mesh->marks[v]);
  Points points = std::move(mesh->positions);
  ChunkFindings findings =
      inspect_chunk({&points, mesh->point_ids, sharing, {}, wants_boundary}, &mesh->tets);
  mesh->positions = std::move(std::get<Vector<Vec3<Real>>>(points));
  return findings;
}

// How much of the mesh a chunk will have.
struct ChunkSize {
  std::uint64_t free_points = 0;  // but for those whose table entry says that they are free now
  std::uint64_t tets = 0;
};

// A chunk's vertices by what their cheapest fusion costs (kernel/fuse/fuse_round.h).
using ChunkCosts = std::array<std::uint32_t, kCostBins>;

template <class Real>
struct MacroLod {
  std::uint64_t tets = 0;
  std::uint64_t removed = 0;  // points that chunks remember (mesh/removed_points.h)
  std::uint32_t chunks = 1;

  // Exactly one of the two: the whole mesh, or the pieces of its chunks and what they need to know
  // of the vertices between them.
  std::optional<WorkMesh<Real>> whole;
  std::unique_ptr<PieceStore> pieces;
  CurveCut cut;                   // that made the chunks, of every macroLoD but the first
  std::vector<ChunkSize> sizes;   // one a chunk
  std::vector<ChunkCosts> costs;  // one a chunk; none where nothing has been judged
  InterfaceTable interface;
  // Vertices that are free in their chunk, but turned out to be at something broken between chunks:
  // to be locked when they are read. Ascending ids; nearly always empty.
  Vector<VertexId> locks;

  // Ways its boundary looks, where surfaces may move.
  FacingGrid facing;

  // Vertices spread over the mesh as its tetrahedra are, from which the next cut is made; none
  // where the mesh is whole.
  Vector<Vec3<Real>> samples;
};

}  // namespace tetfusion
