#include "io/vtk/vtu_cells.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/blocks.h"
#include "io/source/cell_kinds.h"
#include "io/vtk/vtu_cell_arrays.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

class CellReader {
 public:
  CellReader(const VtuInput& input, const OpenOptions& options, Vector<std::uint8_t>* used)
      : input_(input), options_(options), used_(used->data()) {}

  FileCells run() {
    std::uint64_t cells = 0;
    for (const VtuPiece& piece : input_.head.pieces) cells += piece.cells;
    cells_.types.resize(cells);
    for_each_piece([&](const Part& part) {
      part.arrays.read_types(part.arrays.open_types(), 0, part.piece.cells, types_of(part));
    });
    cells_.tets_only = all_tets();
    for_each_piece([&](const Part& part) {
      cells_.ghosts +=
          part.arrays.mark_ghosts(part.arrays.open_ghosts(), 0, part.piece.cells, types_of(part));
    });
    leave_out_patches(options_, cells_.types);
    if (cells_.tets_only) {
      if (cells > kMaxTets) fail_too_many_tets(input_.file.path(), cells);
      cells_.tets.resize(cells);
      for_each_piece([&](const Part& part) { read_tets(part); });
      if (cells_.ghosts > 0) mark_tets();
    } else {
      cells_.offsets.resize(cells + 1);
      cells_.offsets[0] = 0;
      for_each_piece([&](const Part& part) { read_mixed(part); });
    }
    return std::move(cells_);
  }

 private:
  // A piece, and what comes before it.
  struct Part {
    const VtuPiece& piece;
    VtuCellArrays arrays;
    std::uint64_t first_cell = 0;
    std::uint64_t first_point = 0;
  };

  template <class F>
  void for_each_piece(F f) {
    std::uint64_t cell = 0;
    std::uint64_t point = 0;
    for (std::size_t p = 0; p < input_.head.pieces.size(); ++p) {
      const VtuPiece& piece = input_.head.pieces[p];
      if (piece.cells > 0) f(Part{piece, VtuCellArrays(input_, p), cell, point});
      cell += piece.cells;
      point += piece.points;
    }
  }

  std::uint8_t* types_of(const Part& part) { return cells_.types.data() + part.first_cell; }

  bool all_tets() const {
    std::atomic<bool> all = true;
    for_each_block(cells_.types.size(), 16 * kCellsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     std::uint8_t differs = 0;
                     for (std::size_t c = begin; c < end; ++c) {
                       differs |= static_cast<std::uint8_t>(cells_.types[c] ^ kVtkTetra);
                     }
                     if (differs != 0) all.store(false, std::memory_order_relaxed);
                   });
    return all;
  }

  // ---- tetrahedra alone ----

  void read_tets(const Part& part) {
    part.arrays.check_tet_offsets(part.arrays.open_offsets());
    const ArrayReader connectivity = part.arrays.open_connectivity();
    part.arrays.check_length(connectivity, 4 * part.piece.cells);
    part.arrays.read_ids(
        connectivity, {0, connectivity.values(), static_cast<VertexId>(part.first_point)},
        [](std::uint64_t value) { return value / 4; }, cells_.ghosts == 0 ? used_ : nullptr,
        cells_.tets.data()->data() + 4 * part.first_cell);
  }

  // After ghosts are known, so that points of ghost cells alone stay unused.
  void mark_tets() {
    for_each_block(cells_.tets.size(), kCellsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t c = begin; c < end; ++c) {
                       if (cells_.types[c] == kLeftOut) continue;
                       for (const VertexId v : cells_.tets[c]) mark_used(used_, v);
                     }
                   });
  }

  // ---- cells of all kinds ----

  void read_mixed(const Part& part) {
    const std::uint64_t cells = part.piece.cells;
    const std::uint64_t base = cells_.connectivity.size();
    std::uint64_t* const ends = cells_.offsets.data() + part.first_cell;
    const ArrayReader offsets = part.arrays.open_offsets();
    part.arrays.read_ends(offsets, 0, cells, ends);
    const ArrayReader connectivity = part.arrays.open_connectivity();
    part.arrays.check_cells(offsets, options_, 0, cells, types_of(part), ends,
                            connectivity.values());
    part.arrays.check_length(connectivity, ends[cells]);
    cells_.connectivity.resize(base + connectivity.values());
    part.arrays.read_ids(
        connectivity, {0, connectivity.values(), static_cast<VertexId>(part.first_point)},
        [&](std::uint64_t value) {
          return static_cast<std::uint64_t>(std::upper_bound(ends + 1, ends + cells + 1, value) -
                                            (ends + 1));
        },
        nullptr, cells_.connectivity.data() + base);
    for (std::uint64_t c = 0; c <= cells; ++c) ends[c] += base;
    mark_mixed(part);
  }

  void mark_mixed(const Part& part) {
    for_each_block(part.piece.cells, kCellsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin; i < end; ++i) {
                       const std::size_t c = part.first_cell + i;
                       if (cells_.types[c] == kLeftOut) continue;
                       const int kept = kept_vertices(cells_.types[c], options_);
                       const VertexId* const ids = &cells_.connectivity[cells_.offsets[c]];
                       for (int k = 0; k < kept; ++k) mark_used(used_, ids[k]);
                     }
                   });
  }

  const VtuInput& input_;
  const OpenOptions& options_;
  std::uint8_t* used_;
  FileCells cells_;
};

}  // namespace

CellTypeCounts count_types(const VtuInput& input) {
  constexpr std::uint64_t kWindow = std::uint64_t{1} << 20;
  CellTypeCounts counts{};
  Vector<std::uint8_t> types;
  for (std::size_t p = 0; p < input.head.pieces.size(); ++p) {
    const std::uint64_t cells = input.head.pieces[p].cells;
    if (cells == 0) continue;
    const VtuCellArrays arrays(input, p);
    const VtuCellArrays::TypeArray reader = arrays.open_types();
    for (std::uint64_t first = 0; first < cells; first += kWindow) {
      types.resize(std::min(kWindow, cells - first));
      arrays.read_types(reader, first, types.size(), types.data());
      for (const std::uint8_t type : types) ++counts[type];
    }
  }
  return counts;
}

std::uint64_t count_ids(const VtuInput& input) {
  std::uint64_t ids = 0;
  for (std::size_t p = 0; p < input.head.pieces.size(); ++p) {
    if (input.head.pieces[p].cells == 0) continue;
    ids += VtuCellArrays(input, p).open_connectivity().values();
  }
  return ids;
}

FileCells read_cells(const VtuInput& input, const OpenOptions& options,
                     Vector<std::uint8_t>* used) {
  return CellReader(input, options, used).run();
}

}  // namespace tetfusion
