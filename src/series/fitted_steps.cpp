#include "series/fitted_steps.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "base/memory_budget.h"
#include "base/resources.h"
#include "driver/rounds/memory_plan.h"
#include "io/source/stream_windows.h"

namespace tetfusion {

namespace {

// Any step may have values twice as wide as another.
std::vector<std::uint64_t> sizes_of(const std::vector<ArrayFit>& fits, const MeshDescription& mesh,
                                    std::uint64_t points) {
  std::vector<std::uint64_t> sizes;
  for (const ArrayFit& fit : fits) {
    const ArrayInfo& info = mesh.point_data.arrays[mesh.point_data.find(fit.name)];
    sizes.push_back(points * info.components * sizeof(double));
  }
  return sizes;
}

std::uint64_t sum_of(const std::vector<std::uint64_t>& sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0});
}

}  // namespace

void StepWidths::add(const MeshDescription& step) {
  point_bytes = std::max(point_bytes, step.point_data.row_bytes());
  cell_bytes = std::max(cell_bytes, step.cell_data.row_bytes());
  for (const ArrayInfo& info : step.point_data.arrays) {
    widest_bytes = std::max(widest_bytes, info.row_bytes());
    widest_point = std::max<std::uint64_t>(widest_point, info.components);
  }
  for (const ArrayInfo& info : step.cell_data.arrays) {
    widest_bytes = std::max(widest_bytes, info.row_bytes());
    if (is_float(info.type)) widest_cell = std::max<std::uint64_t>(widest_cell, info.components);
  }
}

StepMemory step_memory(std::uint64_t points, std::uint64_t cells, const StepWidths& step) {
  // The map's mesh and the origins of its cells are there once; what fitting takes of the widest
  // array, what averaging does, and windows of the step and of what is written, for each step.
  constexpr std::uint64_t kWindows = std::uint64_t{16} << 20;
  const std::uint64_t once = kProcessBytes + points * (24 + 16) + cells * (41 + 16 + 4);
  const std::uint64_t of_step =
      points * step.point_bytes + cells * step.cell_bytes +
      std::max(points * step.widest_point * 3 * sizeof(double),
               step.widest_cell == 0 ? 0 : cells * (step.widest_cell + 1) * sizeof(double)) +
      kWindows +
      stream_window(step.widest_bytes) * (step.widest_bytes + step.widest_point * sizeof(double));
  return {once, of_step};
}

bool have_room_for_two(const StepMemory& needs, std::uint64_t memory) {
  MemoryBudget budget(memory_to_use(memory));
  const auto one =
      budget.reserve(needs.once + needs.of_step, "the arrays of a step on the simplified mesh");
  return budget.free() >= needs.of_step;
}

FittedSteps::FittedSteps(const std::string& folder, const MapFile& map, std::vector<ArrayFit> fits,
                         const MeshDescription& first, std::size_t steps)
    : map_(map),
      fits_(std::move(fits)),
      sizes_(sizes_of(fits_, first, map.counts().points)),
      weights_(map, folder),
      file_(folder, steps * sum_of(sizes_)) {}

std::vector<MovedArray> FittedSteps::add(std::size_t step, MeshSource* source,
                                         const RunContext& context) {
  std::vector<MovedArray> moved = fit_arrays(map_, weights_, source, fits_, context);
  for (std::size_t a = 0; a < moved.size(); ++a) {
    file_.write(offset(step, a), moved[a].array.bytes);
    moved[a].array.bytes = {};
  }
  return moved;
}

std::vector<MovedArray> FittedSteps::fit(const std::vector<std::string>& names, MeshSource* source,
                                         const RunContext& context) const {
  std::vector<ArrayFit> fits;
  for (const std::string& name : names) fits.push_back({name});
  return fit_arrays(map_, weights_, source, fits, context, false);
}

DataArray FittedSteps::read(std::size_t step, std::size_t array, const ArrayInfo& info) const {
  DataArray out;
  out.info = info;
  out.info.tuples = map_.counts().points;
  out.bytes.resize(out.info.bytes());
  file_.read(offset(step, array), out.bytes);
  return out;
}

std::uint64_t FittedSteps::offset(std::size_t step, std::size_t array) const {
  return step * sum_of(sizes_) +
         std::accumulate(sizes_.begin(), sizes_.begin() + static_cast<std::ptrdiff_t>(array),
                         std::uint64_t{0});
}

}  // namespace tetfusion
