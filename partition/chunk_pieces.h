// Chunks as bytes: a chunk is scattered into pieces, one for each chunk of the next round that gets
// tetrahedra of it, and a chunk of the next round is gathered from the pieces that were left for
// it.
//
// A vertex is free in a chunk if all its tetrahedra are there; any other is marked kOnInterface, in
// every chunk that has it. Work that leaves marked vertices alone never writes what another chunk
// reads, so chunks may be worked on side by side.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/id_map.h"
#include "io/store/piece_store.h"
#include "mesh/work_mesh.h"
#include "partition/curve_cut.h"
#include "partition/interface_table.h"

namespace tetfusion {

// The numbers of pass in which a gathered chunk remembers what was before: what it remembers has
// number 1, so passes over it begin with this one.
inline constexpr std::uint16_t kFirstPassNumber = 2;

// Of a piece of memory, where its columns lie; `Byte` is const for one that is read.
template <class Real, class Byte>
struct PieceColumns;

// Makes pieces. Keeps its scratch memory; one a thread.
template <class Real>
class ChunkScatter {
 public:
  // Adds the pieces of `mesh`, chunk `source` of this round, to the store. Vertices without
  // tetrahedra are left out. Appends a report for each vertex on the interface of this round or of
  // the next.
  void scatter(const WorkMesh<Real>& mesh, const CurveCut& next, std::uint32_t source,
               PieceStore* to, Vector<InterfaceReport>* reports);

  // The same where the next cut is this one: one piece, for the chunk itself. Reports nothing.
  void keep(const WorkMesh<Real>& mesh, std::uint32_t chunk, PieceStore* to);

  // What the last call has put into each piece.
  struct PieceSize {
    std::uint32_t bucket = 0;
    std::uint64_t free_vertices = 0;  // in one chunk now as before
    std::uint64_t tets = 0;
  };
  const std::vector<PieceSize>& sizes() const { return sizes_; }
  // The lowest chunk that got a vertex in the last call; kNoVertex for one without tetrahedra.
  std::uint32_t chunk_of(VertexId v) const { return low_[v]; }

 private:
  void choose_buckets(const WorkMesh<Real>& mesh, const CurveCut& next);
  void sort_tets(const WorkMesh<Real>& mesh);
  void add_pieces(const WorkMesh<Real>& mesh, std::uint32_t source, PieceStore* to);
  void put_piece(const WorkMesh<Real>& mesh, std::uint32_t slot);
  void collect_vertices(const WorkMesh<Real>& mesh, std::span<const std::uint32_t> tets,
                        std::uint32_t slot);
  std::uint64_t put_vertices(const WorkMesh<Real>& mesh, std::uint32_t bucket,
                             const PieceColumns<Real, std::byte>& to) const;
  void put_tets(const WorkMesh<Real>& mesh, std::span<const std::uint32_t> tets,
                const PieceColumns<Real, std::byte>& to) const;

  Vector<std::uint32_t> bucket_;  // of a vertex
  Vector<std::uint32_t> low_,
      high_;  // of a vertex: the lowest and highest bucket of its tetrahedra
  Vector<std::uint32_t> tet_bucket_;
  std::vector<std::uint32_t> buckets_;  // that get a piece, ascending
  Vector<std::uint32_t> slot_of_bucket_;
  Vector<std::uint32_t> begins_;  // of each slot's tetrahedra in order_; one entry more
  Vector<std::uint32_t> order_;
  Vector<std::uint32_t> stamp_;  // the last slot that has used a vertex
  Vector<VertexId> local_;
  Vector<VertexId> used_;
  Vector<std::byte> buffer_;
  std::vector<std::pair<std::size_t, std::size_t>> extents_;  // of the pieces in buffer_
  std::vector<PieceSize> sizes_;
};

// Puts chunks together. Keeps its scratch memory; one a thread.
template <class Real>
class ChunkGather {
 public:
  // Replaces *mesh, whose steering width and columns' types say what a row holds, by a chunk, in
  // the order of its pieces.
  void gather(std::uint32_t chunk, const PieceStore& from, const InterfaceTable& interface,
              WorkMesh<Real>* mesh);

 private:
  using Piece = PieceColumns<Real, const std::byte>;
  void make_room(const std::vector<Piece>& pieces, WorkMesh<Real>* mesh);
  std::size_t take_vertices(const Piece& columns, std::size_t first, std::uint32_t chunk,
                            const InterfaceTable& interface, WorkMesh<Real>* mesh);
  void take_tets(const Piece& columns, std::size_t first, WorkMesh<Real>* mesh);
  void take_removed(const Piece& columns, std::size_t first_tet, WorkMesh<Real>* mesh);

  IdMap known_;  // by point ids
  Vector<VertexId> new_ids_;
};

extern template class ChunkScatter<float>;
extern template class ChunkScatter<double>;
extern template class ChunkGather<float>;
extern template class ChunkGather<double>;

}  // namespace tetfusion
