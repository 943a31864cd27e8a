// The simplified mesh in the order in which a progressive file wants it: by the numbers of the
// original.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/rounds/rounds.h"
#include "io/progressive/progressive_file.h"
#include "io/store/scratch.h"

namespace tetfusion {

// What progress is reported as.
inline constexpr const char* kWayBackPhase = "way back";

// Sorts by way of the scratch, a range of numbers after another, so that only one of these has to
// be in memory.
template <class Real>
class ProgressiveBase {
 public:
  // About as many bytes a range takes.
  static constexpr std::uint64_t kRangeBytes = std::uint64_t{16} << 20;

  // Of an original of so many points and cells; `layout` has the cells' numbers as its last column.
  ProgressiveBase(const WorkMesh<Real>& layout, std::uint64_t points, std::uint64_t cells,
                  Scratch* scratch);

  // All chunks, then points that only cells of lower dimension use, then end(). Like those below it
  // reports progress, 0..1, and throws what RunContext::check() throws.
  void add(const MacroLod<Real>& mesh, const RunContext& context, MemoryBudget* budget);
  void add(PointRows points);
  void end() { store_->seal(); }

  // Each point is noted in `known`.
  void put_points(const RunContext& context, ProgressiveWriter* writer, std::vector<bool>* known);
  void put_tets(const RunContext& context, ProgressiveWriter* writer);

 private:
  void add_chunk(const WorkMesh<Real>& chunk);
  void add_rows(const PointRows& points, const TetRows& tets);

  const WorkMesh<Real>& layout_;
  std::size_t point_row_, tet_row_;
  std::uint32_t points_a_range_, tets_a_range_;
  std::uint32_t point_ranges_, tet_ranges_;
  std::unique_ptr<PieceStore> store_;
  std::uint32_t sources_ = 0;
};

extern template class ProgressiveBase<float>;
extern template class ProgressiveBase<double>;

}  // namespace tetfusion
