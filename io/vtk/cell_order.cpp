#include "io/vtk/cell_order.h"

#include <algorithm>

#include "mesh/split_cells.h"

namespace tetfusion {

std::int64_t CellOrder::end(std::uint64_t cell) const {
  return static_cast<std::int64_t>(cell < tets ? 4 * (cell + 1)
                                               : 4 * tets + lower->offsets[cell - tets + 1]);
}

std::uint8_t CellOrder::type(std::uint64_t cell) const {
  return cell < tets ? std::uint8_t{kVtkTetra} : lower->types[cell - tets];
}

void put_ends_and_types(const CellOrder& cells, VtuWriter* writer) {
  // Of a run from `first` on: so many are tetrahedra.
  const auto tets_in = [&](std::uint64_t first, std::uint64_t count) {
    return first < cells.tets ? std::min(count, cells.tets - first) : 0;
  };
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        const std::uint64_t tets = tets_in(first, count);
        for (std::uint64_t i = 0; i < tets; ++i)
          out[i] = static_cast<std::int64_t>(4 * (first + i + 1));
        for (std::uint64_t i = tets; i < count; ++i) out[i] = cells.end(first + i);
      });
  writer->put_computed<std::uint8_t>(
      [&](std::uint64_t first, std::uint64_t count, std::uint8_t* out) {
        const std::uint64_t tets = tets_in(first, count);
        std::fill_n(out, tets, std::uint8_t{kVtkTetra});
        for (std::uint64_t i = tets; i < count; ++i) out[i] = cells.type(first + i);
      });
}

}  // namespace tetfusion
