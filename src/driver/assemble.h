// Chunks, put together from what the import has scattered for them: ordered, judged, and marked.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/input_facts.h"
#include "driver/macro_lod.h"
#include "io/scratch.h"

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

// `layout` is empty and says what a row holds. `tets` has, for each chunk, pieces of
//
//   count, tetrahedra by the points' ids in the input, cell columns
//
// and `points` those of
//
//   count, ids, marks (kLocked, kOnInterface, kLast), positions, each steering component, point
//   columns
//
// both as RowWriter makes them; what has been put together is forgotten. `regions` are cell
// columns: a vertex where tetrahedra of different regions meet is locked. `numbered`: of so many
// cells in all the last column has the numbers; 0: it has not.
//
// With `work` the chunks go there and not into pieces, and what only other chunks know of a chunk's
// vertices on the interface is not marked in it yet.
template <class Real>
Assembly<Real> assemble_chunks(const WorkMesh<Real>& layout, const Box& box, std::uint32_t chunks,
                               const std::vector<std::size_t>& regions, std::uint64_t numbered,
                               PieceStore& tets, PieceStore& points, const ChunkWork<Real>& work,
                               const RunContext& context, MemoryBudget* budget, Scratch* scratch);

// One chunk by itself, as `work` would get it, of those that assemble_chunks() takes.
template <class Real>
WorkMesh<Real> assemble_excerpt(const WorkMesh<Real>& layout, const Box& box, std::uint32_t chunk,
                                const std::vector<std::size_t>& regions, PieceStore& tets,
                                PieceStore& points);

}  // namespace tetfusion
