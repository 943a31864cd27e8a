// Meshes cut into chunks, and put together again.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "io/store/scratch.h"
#include "mesh/work_mesh.h"
#include "partition/chunk_pieces.h"

namespace tetfusion::testing {

// An empty mesh with the columns and the steering width of this one.
template <class Real>
WorkMesh<Real> layout_of(const WorkMesh<Real>& mesh);

template <class Real>
Box box_of(const WorkMesh<Real>& mesh);

// Chunks of the curve of that round with about the same number of tetrahedra each.
template <class Real>
CurveCut cut_evenly(const WorkMesh<Real>& mesh, std::uint32_t chunks, std::uint32_t round);

struct CutMesh {
  std::uint32_t chunks = 1;
  std::unique_ptr<PieceStore> pieces;
  InterfaceTable interface;
};

// Scatters a mesh that is whole. `name` is the generation's.
template <class Real>
CutMesh cut_up(const WorkMesh<Real>& mesh, std::uint32_t chunks, std::uint32_t round,
               Scratch* scratch, const std::string& name = "cut");

// Scatters the chunks of one cut to those of another.
template <class Real>
CutMesh cut_anew(const std::vector<WorkMesh<Real>>& chunks, const CurveCut& cut, Scratch* scratch,
                 const std::string& name);

template <class Real>
std::vector<WorkMesh<Real>> gather_all(const CutMesh& mesh, const WorkMesh<Real>& layout);

// The chunks with tetrahedra of each vertex, by its id.
template <class Real>
std::map<VertexId, std::set<std::size_t>> chunks_by_id(const std::vector<WorkMesh<Real>>& chunks);

// What a pass over a chunk relies on: a vertex is free where all its tetrahedra are, and else on
// the interface of every chunk that has it, which know the lowest and the highest of them; the
// incidence is right. Reports to GoogleTest.
template <class Real>
void expect_chunks_know_their_vertices(const std::vector<WorkMesh<Real>>& chunks);

// Puts chunks together: vertices ascend by id, nothing is on an interface. Throws std::logic_error
// where two chunks do not agree about a vertex.
template <class Real>
WorkMesh<Real> join(const std::vector<WorkMesh<Real>>& chunks);

// A mesh as text, one a tetrahedron, sorted: the ids, positions, lasting marks, steering values and
// rows of its corners, its own rows, and its removed points. Equal for meshes that are the same up
// to order. `with_ids`: which of the four ids a fused vertex keeps depends on the order.
template <class Real>
std::vector<std::string> contents(const WorkMesh<Real>& mesh, bool with_ids = true);

}  // namespace tetfusion::testing
