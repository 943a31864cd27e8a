#include "io/source/cell_windows.h"

#include <algorithm>
#include <vector>

#include "base/blocks.h"
#include "io/source/cell_kinds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// Where a block's cells go.
struct Places {
  std::uint64_t tets = 0;
  std::uint64_t lower = 0;
  std::uint64_t lower_ids = 0;
};

void put_block(const MixedCells& cells, std::size_t begin, std::size_t end, Places at,
               CellWindow* out) {
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint8_t type = cells.types[i];
    if (type == kLeftOut) continue;
    const std::uint64_t vertices = cells.ends[i + 1] - cells.ends[i];
    const VertexId* const v = cells.ids.data() + (cells.ends[i] - cells.ends[0]);
    if (type == kVtkTetra) {
      if (!out->tet_rows.empty()) out->tet_rows[at.tets] = cells.first + i;
      out->tets[at.tets++] = {v[0], v[1], v[2], v[3]};
      continue;
    }
    std::copy_n(v, vertices, out->lower.connectivity.data() + at.lower_ids);
    at.lower_ids += vertices;
    out->lower.types[at.lower] = type;
    out->lower_rows[at.lower++] = cells.first + i;
    out->lower.offsets[at.lower] = at.lower_ids;
  }
}

}  // namespace

void clear(CellWindow* window) {
  window->tets.clear();
  window->tet_rows.clear();
  window->lower.types.clear();
  window->lower.offsets.clear();
  window->lower.connectivity.clear();
  window->lower_rows.clear();
  window->ghost_cells = 0;
}

void sort_cells(const MixedCells& cells, CellWindow* out) {
  const std::size_t count = cells.types.size();
  std::vector<Places> places(block_count(count, kCellsPerBlock) + 1);
  for_each_block(count, kCellsPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (cells.types[i] == kLeftOut) continue;
      const bool tet = cells.types[i] == kVtkTetra;
      places[b + 1].tets += tet ? 1 : 0;
      places[b + 1].lower += tet ? 0 : 1;
      places[b + 1].lower_ids += tet ? 0 : cells.ends[i + 1] - cells.ends[i];
    }
  });
  for (std::size_t b = 1; b < places.size(); ++b) {
    places[b].tets += places[b - 1].tets;
    places[b].lower += places[b - 1].lower;
    places[b].lower_ids += places[b - 1].lower_ids;
  }
  const Places& all = places.back();
  out->tets.resize(all.tets);
  if (all.tets < count) out->tet_rows.resize(all.tets);
  out->lower_rows.resize(all.lower);
  out->lower.types.resize(all.lower);
  out->lower.connectivity.resize(all.lower_ids);
  if (all.lower > 0) out->lower.offsets.assign(all.lower + 1, 0);
  for_each_block(count, kCellsPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    put_block(cells, begin, end, places[b], out);
  });
}

}  // namespace tetfusion
