// From a file to the first macroLoD: the mesh is read in windows and cut into chunks (scatter.h),
// each chunk is put in the order of the curve and judged, and what must stay is marked. In memory
// is, beside four bytes and a bit a point and cells of lower dimension, what grows with the
// interface between chunks alone.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/import/assemble.h"
#include "driver/import/scatter.h"
#include "driver/request/input_facts.h"
#include "driver/rounds/macro_lod.h"

namespace tetfusion {

// An empty mesh that says what a row of this run's meshes holds.
template <class Real>
WorkMesh<Real> layout_of(const CarriedArrays& carried, std::uint32_t steering_width);
// The column of ImportSettings::keeps_numbers.
inline Column number_column() { return {value_type_of<TetId>(), 1, {}}; }

struct ImportSettings : ScatterSettings {
  std::vector<std::size_t> regions;  // of CarriedArrays::cell_data: interfaces that stay
  std::uint32_t quadric_width = 0;   // WorkMesh::quadric_width of pieces
  bool keeps_numbers = false;        // the last cell column is each cell's number in the stream
};

// The first round may be done with each chunk as it is put together, so that it need not be written
// and read again in between. Without `begin` it is not done.
template <class Real>
struct FirstRound {
  // Called when all of the mesh has been scattered and the fields' ranges are known; it may happen
  // again.
  std::function<void()> scattered;
  // Called before `begin` with an excerpt of the mesh, where one was asked for.
  std::function<void(const Box& box, std::uint64_t tets, WorkMesh<Real>* excerpt)> look;
  // Called once, when all is known that a round begins with (Rounds::begin).
  std::function<void(const Box& box, std::uint64_t tets, std::vector<std::uint64_t> shares,
                     const Vector<Vec3<Real>>& samples)>
      begin;
  ChunkWork<Real> work;
  // Called where the round was in vain; the chunks are put together once more then.
  std::function<void()> drop;
};

// What is known of the input, and what of it is not simplified.
template <class Real>
struct ImportedInput {
  Box box;
  LowerPart<Real> lower;
  InputFacts facts;
  std::uint64_t interesting_points = 0;
  std::vector<bool> rewound;  // Assembly's, with ImportSettings::keeps_numbers
};

template <class Real>
struct ImportedMesh : ImportedInput<Real> {
  // With `first_round_done` the interface table, with marks alone; the mesh is what that round ends
  // with.
  MacroLod<Real> mesh;
  bool first_round_done = false;
};

// The first round is not done where the mesh is in one piece, and where it turns out, after the
// chunks, that something is broken between them which vertices that were free belong to. Throws
// Error.
template <class Real>
ImportedMesh<Real> import_mesh(const ImportInput& input, const ImportSettings& settings,
                               const FirstRound<Real>& first_round, const ImportPlace& place);

}  // namespace tetfusion
