// Chunks, put together from what the import has scattered for them: ordered, judged, and marked.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "driver/import/scatter.h"
#include "driver/request/input_facts.h"
#include "driver/rounds/macro_lod.h"

namespace tetfusion {

// How much of a run is done when all chunks are put together; and where the first round, which
// often does most, is done with them.
inline constexpr double kAssembledShare = 0.25, kAssembledWithWork = 0.6;

template <class Real>
struct Assembly {
  // Where chunks were handed to `work`: its interface table, with marks alone, and locks.
  MacroLod<Real> mesh;
  InputFacts facts;
  // One for each cell of the input, where the last column of cells has their numbers: 1 where its
  // last two corners were the other way round. Empty: there is none.
  std::vector<bool> rewound;
};

// Does something with a chunk that has been put together; a worker is a thread.
template <class Real>
using ChunkWork = std::function<void(std::uint32_t chunk, std::size_t worker, WorkMesh<Real>*)>;

// What chunks are put together from; all of it outlives the work. `from.tets` has, for each chunk,
// pieces of
//
//   count, tetrahedra by the points' ids in the input, cell columns
//
// and `from.points` those of
//
//   count, ids, marks (kLocked, kCarried, kOnInterface, kLast), positions, each steering component,
//   point columns
//
// both as RowWriter makes them; what has been put together is forgotten there.
template <class Real>
struct ChunkParts {
  const WorkMesh<Real>& layout;  // empty: what a row holds
  const ScatteredMesh<Real>& from;
  // Cell columns: a vertex where tetrahedra of different regions meet is counted ...
  const std::vector<std::size_t>& regions;
  bool surfaces_move;      // ... and, where this is false, locked
  std::uint64_t numbered;  // of so many cells in all the last column has the numbers; 0: it has not

  std::uint64_t bytes(std::uint32_t chunk) const {
    return from.tets->bytes(chunk) + from.points->bytes(chunk);
  }
};

// With `work` the chunks go there and not into pieces, and what only other chunks know of a chunk's
// vertices on the interface is not marked in it yet.
template <class Real>
Assembly<Real> assemble_chunks(const ChunkParts<Real>& parts, const ChunkWork<Real>& work,
                               const ImportPlace& place);

// The excerpt, as `work` would get a chunk. Its numbers, if there are any, are of no use.
template <class Real>
WorkMesh<Real> assemble_excerpt(const ChunkParts<Real>& parts);

}  // namespace tetfusion
