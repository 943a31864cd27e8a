// The chunks of an import, as they come from what was scattered for them.
#pragma once

#include <cstdint>
#include <vector>

#include "base/id_map.h"
#include "driver/rounds/windows.h"
#include "io/store/piece_store.h"
#include "mesh/work_mesh.h"
#include "partition/curve_cut.h"

namespace tetfusion {

// Between two chunks it holds little, so that there is room for work on the chunk; one a thread.
template <class Real>
class ChunkLoader {
 public:
  // `layout` is empty and says what a row holds; `box` holds all points.
  ChunkLoader(const WorkMesh<Real>& layout, const Box& box);

  // Replaces *mesh: the chunk's tetrahedra, not rewound, and the points that they use, both in the
  // order of the curve. `tets` and `points` are what ChunkParts says.
  void load(std::uint32_t chunk, PieceStore& tets, PieceStore& points, WorkMesh<Real>* mesh);

 private:
  void read_points(std::vector<RowReader> readers);
  void read_tets(std::vector<RowReader> readers);

  ShiftedCurve curve_;
  WorkMesh<Real> layout_;
  WorkMesh<Real> raw_;
  IdMap places_;  // of points in the chunk
};

extern template class ChunkLoader<float>;
extern template class ChunkLoader<double>;

}  // namespace tetfusion
