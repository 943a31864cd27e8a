// The original's points and cells with their values, put aside at the start of a run; and at its
// end the places and values of new points fitted to them (kernel/fit/vertex_moves.h, value_fit.h),
// and the values of tetrahedra averaged (kernel/fit/cell_means.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "driver/rounds/macro_lod.h"
#include "driver/rounds/original_rows.h"
#include "kernel/fit/cell_means.h"
#include "kernel/fit/value_fit.h"

namespace tetfusion {

// Columns of a chunk.
struct ColumnsToFit {
  std::vector<std::uint32_t> points, cells;  // of floating-point numbers
  std::vector<std::uint32_t> labels;         // of cells: what lies in another region does not count
  bool empty() const { return points.empty() && cells.empty(); }
};

// What a run that is gone on with must know.
struct KeptValues {
  std::uint32_t chunks = 0;             // of the original; 0: nothing has been put aside yet
  std::vector<std::uint8_t> fractions;  // of each column of cells: has it some?
};

template <class Real>
class OriginalValues {
 public:
  // The layout is that of the meshes. The scratch outlives this.
  OriginalValues(Scratch* scratch, const WorkMesh<Real>& layout, ColumnsToFit columns,
                 bool surfaces_move);

  // Puts aside a mesh of which nothing has been fused yet: each chunk once, from any thread,
  // between begin() and end(). What was put aside before is forgotten.
  void begin();
  void add(std::uint32_t chunk, const WorkMesh<Real>& mesh);
  void end();

  // So that the run can be gone on with: what was put aside is kept, and resume() takes it up
  // again.
  KeptValues keep();
  void resume(const KeptValues& kept, Checkpoint* from);

  std::uint32_t chunks() const { return is_whole_ ? kept_.chunks : 0; }
  const ColumnsToFit& columns() const { return columns_; }
  bool have_starts() const { return surfaces_move_; }
  // Those of cells but for columns of whole numbers alone, which may be labels.
  std::vector<std::uint32_t> columns_to_average() const;
  // Of points: positions, where surfaces move where to look for them, and the columns; of cells:
  // centres, volumes in some unit, hashes of corners, columns and labels. Null where there are no
  // columns.
  const OriginalRows* points() const { return points_ ? &*points_ : nullptr; }
  const OriginalRows* cells() const { return cells_ ? &*cells_ : nullptr; }

 private:
  void add_points(std::uint32_t chunk, const WorkMesh<Real>& mesh);
  void add_cells(std::uint32_t chunk, const WorkMesh<Real>& mesh);

  ColumnsToFit columns_;
  bool surfaces_move_;
  std::optional<OriginalRows> points_, cells_;
  KeptValues kept_;
  bool is_whole_ = false;
};

// What a thread needs to fit the values of a chunk.
template <class Real>
struct FitTools {
  TetWalk<Real> walk;
  ValueFit<Real> points;
  CellMeans<Real> cells;
};

// Of a macroLoD that is to be written.
template <class Real>
class FittedValues {
 public:
  // The original, of which something was put aside, and the mesh outlive this.
  FittedValues(const OriginalValues<Real>& original, const MacroLod<Real>& mesh, MoveLimits moves,
               int threads, Scratch* scratch);

  // Fits the values of the chunk, and before them the places of vertices inside of it. Safe to call
  // from several threads, each with its own tools. The same for any number of threads.
  void fit(std::uint32_t chunk, FitTools<Real>* tools, WorkMesh<Real>* mesh);
  // Bytes of memory that takes.
  std::uint64_t memory(std::uint32_t chunk) const;
  // So many seconds have the threads spent on it, added up; when none is at it.
  double seconds() const { return seconds_; }

 private:
  void fit_points(std::uint32_t chunk, FitTools<Real>* tools, WorkMesh<Real>* mesh) const;
  void average_cells(std::uint32_t chunk, FitTools<Real>* tools, WorkMesh<Real>* mesh) const;

  const OriginalValues<Real>& original_;
  const MacroLod<Real>& mesh_;
  const MoveLimits moves_;
  std::optional<SortedRows> points_, cells_;
  std::mutex seconds_mutex_;
  double seconds_ = 0;
};

// Bytes of memory that fitting a chunk of so many tetrahedra takes, in a mesh whose original had so
// many points and cells of which something was put aside.
std::uint64_t fit_memory(std::uint64_t points, std::uint64_t cells, std::uint64_t tets);

extern template class OriginalValues<float>;
extern template class OriginalValues<double>;
extern template class FittedValues<float>;
extern template class FittedValues<double>;

}  // namespace tetfusion
