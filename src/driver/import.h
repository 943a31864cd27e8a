// From a file to the first macroLoD: the mesh is read in windows and cut into chunks, each chunk is
// put in the order of the curve and judged, and what must stay is marked.
//
// Passes over the file, each in windows: the points (bounding box; where there are several chunks
// once more, for the chunk that each is at home in), the tetrahedra (scattered into chunks), the
// points with their arrays (scattered to the chunks that need them). Then the chunks, one by one.
// The mesh itself is never whole in memory; in memory are four bytes a point, and what grows with
// the interface between chunks alone.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/memory_budget.h"
#include "base/resources.h"
#include "base/run_context.h"
#include "driver/assemble.h"
#include "driver/carried_arrays.h"
#include "driver/input_facts.h"
#include "driver/macro_lod.h"
#include "driver/steering.h"
#include "io/mesh_stream.h"
#include "io/scratch.h"
#include "mesh/boundary_sample.h"

namespace tetfusion {

// An empty mesh that says what a row of this run's meshes holds.
template <class Real>
WorkMesh<Real> layout_of(const CarriedArrays& carried, std::uint32_t steering_width);

struct ImportSettings {
  std::uint64_t chunk_tets = 0;
  std::vector<std::size_t> regions;  // of CarriedArrays::cell_data: interfaces that stay
  std::uint32_t quadric_width = 0;   // WorkMesh::quadric_width of pieces
  // Cells and points a window: a few megabytes of each. The result does not depend on them.
  std::uint64_t cell_window = std::uint64_t{1} << 19;
  std::uint64_t point_window = std::uint64_t{1} << 18;
  // Where it is not null all tetrahedra are shown to it, but only the chunk in the middle of the
  // curve is made: a mesh in one piece, in which vertices that other chunks have are on the
  // interface. Facts are then that chunk's.
  BoundarySample* sample = nullptr;
  bool has_deviations = false;  // WorkMesh::has_deviations of pieces
};

// The first round may be done with each chunk as it is put together, so that it need not be written
// and read again in between. Both empty: it is not done.
template <class Real>
struct FirstRound {
  // Called once, when all is known that a round begins with (Rounds::begin).
  std::function<void(const Box& box, std::uint64_t tets, std::vector<std::uint64_t> shares,
                     const Vector<Vec3<Real>>& samples)>
      begin;
  ChunkWork<Real> work;
};

// What is not simplified but belongs to the result: cells of lower dimension, with their rows, and
// the points that only they use.
template <class Real>
struct LowerPart {
  LowerCells cells;             // by ids in the input
  std::vector<Column> columns;  // cell columns
  Vector<VertexId> vertices;    // all that the cells use, ascending
  Vector<VertexId> loose_ids;   // of them those that no tetrahedron uses, ascending
  Vector<Vec3<Real>> loose_positions;
  std::vector<Column> loose_columns;  // point columns
};

// `low` is above `high` where there is no value.
struct SteeringBox {
  std::vector<double> low, high;
};

template <class Real>
struct ImportedMesh {
  // With `first_round_done` the interface table, with marks alone; the mesh is what that round ends
  // with.
  MacroLod<Real> mesh;
  bool first_round_done = false;
  Box box;
  LowerPart<Real> lower;
  InputFacts facts;
  // Of each steering value, over the points that tetrahedra use, where all of the field are finite.
  SteeringBox steering_box;
};

// The first round is not done where the mesh is in one piece, and where it turns out, after the
// chunks, that something is broken between them which vertices that were free belong to: `begin`
// may have been called, and what it began must be dropped. Throws Error.
template <class Real>
ImportedMesh<Real> import_mesh(const MeshDescription& description, const MeshStream& stream,
                               const CarriedArrays& carried, const Steering& steering,
                               const ImportSettings& settings, const FirstRound<Real>& first_round,
                               const RunContext& context, PhaseClock* clock, MemoryBudget* budget,
                               Scratch* scratch);

}  // namespace tetfusion
