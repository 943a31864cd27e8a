// The original's points with their values, put aside at the start of a run; and the values of new
// points, fitted to them at its end (kernel/value_fit.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "driver/macro_lod.h"
#include "io/scratch.h"
#include "kernel/value_fit.h"

namespace tetfusion {

template <class Real>
class OriginalValues {
 public:
  // Of these columns of the points, of floating-point numbers. The scratch outlives this.
  OriginalValues(Scratch* scratch, std::vector<std::uint32_t> columns, bool surfaces_move)
      : scratch_(scratch), columns_(std::move(columns)), surfaces_move_(surfaces_move) {}

  // Puts aside a mesh of which nothing has been fused yet: each chunk once, from any thread,
  // between begin() and end(). What was put aside before is forgotten.
  void begin();
  void add(std::uint32_t chunk, const WorkMesh<Real>& mesh);
  void end();

  // So that the run can be gone on with: what was put aside is kept, and resume() takes it up
  // again. keep() returns the number of chunks; 0: nothing has been put aside yet.
  std::uint32_t keep();
  void resume(std::uint32_t chunks, Checkpoint* from);

  const std::vector<std::uint32_t>& columns() const { return columns_; }
  bool have_starts() const { return surfaces_move_; }
  std::uint32_t chunks() const { return is_whole_ ? chunks_.load() : 0; }
  const PieceStore& store() const { return *store_; }  // a bucket a chunk; after end()

 private:
  Scratch* scratch_;
  std::vector<std::uint32_t> columns_;
  bool surfaces_move_;
  std::unique_ptr<PieceStore> store_;
  std::atomic<std::uint32_t> chunks_ = 0;
  bool is_whole_ = false, is_kept_ = false;
};

// Of a macroLoD that is to be written.
template <class Real>
class FittedValues {
 public:
  // Points have the columns of the layout. The original and the mesh outlive this.
  FittedValues(const OriginalValues<Real>& original, const MacroLod<Real>& mesh,
               const WorkMesh<Real>& layout, int threads, Scratch* scratch);

  // Fits the values of the chunk. Safe to call from several threads, each with its own tool. The
  // same for any number of threads.
  void fit(std::uint32_t chunk, ValueFit<Real>* tool, WorkMesh<Real>* mesh);
  // Bytes of memory that takes.
  std::uint64_t memory(std::uint32_t chunk) const;
  // So many seconds have the threads spent on it, added up; when none is at it.
  double seconds() const { return seconds_; }

 private:
  void sort_points(int threads, Scratch* scratch);
  std::uint64_t points_of(std::uint32_t chunk) const;
  template <class Use>
  void for_each_piece(std::uint32_t chunk, Use use) const;

  const OriginalValues<Real>& original_;
  const MacroLod<Real>& mesh_;
  std::vector<std::size_t> strides_;    // bytes a row, of each column
  std::unique_ptr<PieceStore> sorted_;  // a bucket a chunk of the mesh, where it has several
  std::mutex seconds_mutex_;
  double seconds_ = 0;
};

// Bytes of memory that fitting a chunk of so many tetrahedra takes, in a mesh whose original had so
// many points.
std::uint64_t fit_memory(std::uint64_t points, std::uint64_t tets);

extern template class OriginalValues<float>;
extern template class OriginalValues<double>;
extern template class FittedValues<float>;
extern template class FittedValues<double>;

}  // namespace tetfusion
