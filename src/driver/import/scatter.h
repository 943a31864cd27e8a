// The first half of an import: a file is read in windows, and what is in them goes to the chunks
// that will be made of it (assemble.h).
//
// Passes over the file, each in windows: the points (bounding box; where there are several chunks
// once more, for the chunk that each is at home in), the tetrahedra (scattered into chunks), the
// points with their arrays (scattered to the chunks that need them; before that, where no
// tetrahedron uses some of them, the fields that steer once more, for their ranges). The mesh
// itself is never whole in memory; four bytes and a bit a point are, and cells of lower dimension.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/memory_budget.h"
#include "base/resources.h"
#include "base/run_context.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/arrays/steering.h"
#include "io/source/mesh_stream.h"
#include "io/store/scratch.h"
#include "mesh/inspection/boundary_sample.h"
#include "mesh/regions/region_of_interest.h"
#include "mesh/work_mesh.h"
#include "partition/curve_cut.h"

namespace tetfusion {

// What is imported: the mesh, which of its arrays come along, and those that steer.
struct ImportInput {
  const MeshStream& stream;
  const CarriedArrays& carried;
  Steering* steering;  // its ranges become those of the points that tetrahedra use
};

// Where it goes, within which memory, and who hears of it.
struct ImportPlace {
  const RunContext& context;
  PhaseClock* clock;
  MemoryBudget* budget;
  Scratch* scratch;
};

struct ScatterSettings {
  std::uint64_t chunk_tets = 0;
  // Cells and points a window at most: a few megabytes of each. The result does not depend on them.
  std::uint64_t cell_window = std::uint64_t{1} << 19;
  std::uint64_t point_window = std::uint64_t{1} << 18;
  // Where it is not null all tetrahedra are shown to it, but only the chunk in the middle of the
  // curve is made: a mesh in one piece, in which vertices that other chunks have are on the
  // interface.
  BoundarySample* sample = nullptr;
  // Points that are locked; null: none. Outlives this.
  const RegionOfInterest* interest = nullptr;
  // Points that share their place with another one are locked then, as the two sides of a crack, or
  // of a contact, would move apart; those between regions are not, but counted, as rounds decide
  // which of them stay; and pieces have WorkMesh::deviations.
  bool surfaces_move = false;
  // Makes an excerpt where there are several chunks. Not with a sample.
  bool excerpt = false;
};

// What is not simplified but belongs to the result: cells of lower dimension, with their rows, and
// the points that only they use.
template <class Real>
struct LowerPart {
  LowerCells cells;             // by ids in the input
  std::vector<Column> columns;  // cell columns, those of arrays
  Vector<TetId> numbers;        // of the cells in the stream, with ImportSettings::keeps_numbers
  Vector<VertexId> vertices;    // all that the cells use, ascending
  Vector<VertexId> loose_ids;   // of them those that no tetrahedron uses, ascending
  Vector<Vec3<Real>> loose_positions;
  std::vector<Column> loose_columns;  // point columns
};

template <class Real>
struct ScatteredMesh {
  std::uint32_t all_chunks = 1;
  std::uint32_t chunks = 1;                  // made: all, or with a sample one
  std::unique_ptr<PieceStore> tets, points;  // what ChunkParts says
  // One more chunk there, number all_chunks: the tetrahedra round a small part of the points, which
  // other chunks have as well, and points of which others are missing as those on the interface.
  bool has_excerpt = false;
  std::uint64_t tet_count = 0;
  Vector<std::uint64_t> chunk_tets;  // of each of all_chunks
  std::uint64_t ghost_cells = 0;
  std::uint64_t valueless_points = 0;    // a value of theirs that steers is not finite
  std::uint64_t interesting_points = 0;  // in the region of interest
  std::uint64_t coincident_points = 0;   // that were locked for it
  Box box;                               // of the points that tetrahedra use
  Vector<Vec3<Real>> samples;            // points, for cuts; none where the mesh is in one piece
  LowerPart<Real> lower;
};

// `layout` is an empty mesh that says what a row holds. Throws Error.
template <class Real>
ScatteredMesh<Real> scatter_mesh(const ImportInput& input, const ScatterSettings& settings,
                                 const WorkMesh<Real>& layout, const ImportPlace& place);

}  // namespace tetfusion
