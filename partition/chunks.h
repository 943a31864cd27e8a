// A mesh cut into chunks, and put together again. Every tetrahedron belongs to one chunk. A vertex
// all of whose tetrahedra are in one chunk is free there; any other lies on the interface and is
// marked so in each chunk that has it. Work on a chunk that leaves its marked vertices alone never
// reads or writes what another chunk's does.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/work_mesh.h"

namespace tetfusion {

// Which tetrahedra each chunk has.
struct Chunking {
  Vector<TetId> tets;            // of the mesh, chunk by chunk, ascending in each
  Vector<std::uint64_t> begins;  // of the chunks in `tets`; one entry more than chunks

  std::size_t chunks() const { return begins.size() - 1; }
};

// The round shifts the cut. A function of the arguments alone, whatever the number of threads.
template <class Real>
Chunking cut_into_chunks(const WorkMesh<Real>& mesh, std::uint64_t chunk_tets, std::uint32_t round);

// Takes chunks out of a mesh. One a thread; keeps its scratch memory.
template <class Real>
class ChunkCutter {
 public:
  // Copies a chunk: its point_ids are the mesh's vertex ids, in the order in which its tetrahedra
  // name them first; its tet_ids the mesh's. A vertex on the interface is marked kOnInterface, and
  // its incidence counts from 0: what work makes of that is the change. Different chunks may be
  // taken, and put back, at the same time.
  WorkMesh<Real> take(WorkMesh<Real>& mesh, const Chunking& chunking, std::size_t chunk);

 private:
  Vector<VertexId> local_;  // of a vertex of the whole mesh; kNoVertex outside take()
};

// What work has left of a chunk, once its vertices are back in the mesh. Tetrahedra name the
// chunk's vertices.
struct ChunkRemains {
  Vector<Tet> tets;
  Vector<TetId> tet_ids;
  Vector<std::uint16_t> flipped;
  Vector<VertexId> vertices;  // the mesh's ids of the chunk's vertices

  // Vertices on the interface whose incidence changed, and by how much, modulo 2^32.
  struct Change {
    VertexId vertex;
    std::uint32_t incidence;
  };
  std::vector<Change> changes;
};

// Writes the chunk's vertices back into the mesh.
template <class Real>
ChunkRemains put_back(WorkMesh<Real> chunk, WorkMesh<Real>* mesh);

// When all chunks have been put back: gives the mesh their tetrahedra, in the order of the chunks,
// and drops the vertices that nothing uses any more. Ids are stale afterwards.
template <class Real>
void join_chunks(std::vector<ChunkRemains> remains, WorkMesh<Real>* mesh);

extern template class ChunkCutter<float>;
extern template class ChunkCutter<double>;

}  // namespace tetfusion
