#include "io/cell_order.h"

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
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) *out++ = cells.end(i);
      });
  writer->put_computed<std::uint8_t>(
      [&](std::uint64_t first, std::uint64_t count, std::uint8_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) *out++ = cells.type(i);
      });
}

}  // namespace tetfusion
