#include "io/vtu_cells.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.h"
#include "io/cell_kinds.h"
#include "mesh/blocks.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::size_t kCellsPerBlock = 65536;

template <class T>
T load(const std::byte* bytes, std::size_t index) {
  T value;
  std::memcpy(&value, bytes + index * sizeof(T), sizeof(T));
  return value;
}

// Several threads may mark one point.
void mark(std::uint8_t* used, VertexId v) {
  std::atomic_ref<std::uint8_t> flag(used[v]);
  if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
}

// Calls f(chunk, T{}) for each chunk of an integer array, T its type.
template <class F>
void for_each_integers(const ArrayReader& reader, F f) {
  visit_type(reader.type(), [&](auto zero) {
    if constexpr (std::is_integral_v<decltype(zero)>) {
      reader.for_each_chunk([&](const Chunk& chunk) { f(chunk, zero); });
    }
  });
}

class CellReader {
 public:
  CellReader(const VtuInput& input, const OpenOptions& options, Vector<std::uint8_t>* used)
      : input_(input), options_(options), used_(used->data()) {}

  VtuCells run() {
    std::uint64_t cells = 0;
    for (const VtuPiece& piece : input_.head.pieces) cells += piece.cells;
    cells_.types.resize(cells);
    for_each_piece([&](const VtuPiece& piece) { read_types(piece); });
    cells_.tets_only = all_tets();
    read_ghosts();
    if (cells_.tets_only) {
      if (cells > kMaxTets) fail_too_many_tets(input_.file.path(), cells);
      cells_.tets.resize(cells);
      for_each_piece([&](const VtuPiece& piece) { read_tets(piece); });
      if (cells_.ghosts > 0) mark_tets();
    } else {
      cells_.offsets.resize(cells + 1);
      cells_.offsets[0] = 0;
      for_each_piece([&](const VtuPiece& piece) { read_mixed(piece); });
    }
    return std::move(cells_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, input_.file.path() + ": " + what);
  }

  template <class F>
  void for_each_piece(F f) {
    piece_ = 0;
    first_cell_ = 0;
    first_point_ = 0;
    for (const VtuPiece& piece : input_.head.pieces) {
      if (piece.cells > 0) f(piece);
      first_cell_ += piece.cells;
      first_point_ += piece.points;
      ++piece_;
    }
  }

  ArrayReader open(const VtuArray& array, const char* name) const {
    return input_.open(array, std::string("cell array \"") + name + "\"" + input_.of_piece(piece_));
  }

  // Cells are numbered within their piece.
  std::string cell_name(std::uint64_t cell) const {
    return "cell " + std::to_string(cell) + input_.of_piece(piece_);
  }

  void read_types(const VtuPiece& piece) {
    const ArrayReader reader = open(piece.types, "types");
    std::uint8_t* const out = cells_.types.data() + first_cell_;
    for_each_integers(reader, [&](const Chunk& chunk, auto zero) {
      using T = decltype(zero);
      for (std::uint64_t i = 0; i < chunk.count; ++i) {
        const T type = load<T>(chunk.data, i);
        // As unsigned, so that negative ones are too large.
        if (static_cast<std::uint64_t>(type) >= VtuCells::kGhost) {
          fail(cell_name(chunk.first + i) + " has the type " + std::to_string(type) +
               ", which VTK does not have" + reader.where(chunk.first + i));
        }
        out[chunk.first + i] = static_cast<std::uint8_t>(type);
      }
    });
  }

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

  // Overwrites the types of ghost cells.
  void read_ghosts() {
    const AttributeSet& data = input_.head.cell_data;
    for (const bool levels : {false, true}) {
      const char* name = levels ? "vtkGhostLevels" : "vtkGhostType";
      const std::size_t index = data.find(name);
      if (index == AttributeSet::npos || is_float(data.arrays[index].type) ||
          data.arrays[index].components != 1) {
        continue;
      }
      std::atomic<std::uint64_t> ghosts = 0;
      for_each_piece([&](const VtuPiece& piece) {
        std::uint8_t* const types = cells_.types.data() + first_cell_;
        for_each_integers(open(piece.cell_data[index], name), [&](const Chunk& chunk, auto zero) {
          using T = decltype(zero);
          std::uint64_t count = 0;
          for (std::uint64_t i = 0; i < chunk.count; ++i) {
            const T value = load<T>(chunk.data, i);
            if (levels ? value <= 0 : (value & T{kGhostDropped}) == 0) continue;
            count += types[chunk.first + i] != VtuCells::kGhost ? 1 : 0;
            types[chunk.first + i] = VtuCells::kGhost;
          }
          ghosts += count;
        });
      });
      cells_.ghosts += ghosts;
    }
  }

  // ---- tetrahedra alone ----

  void read_tets(const VtuPiece& piece) {
    check_tet_offsets(open(piece.offsets, "offsets"));
    const ArrayReader reader = open(piece.connectivity, "connectivity");
    if (reader.values() != 4 * piece.cells) wrong_length(reader, 4 * piece.cells);
    VertexId* const out = cells_.tets.data()->data() + 4 * first_cell_;
    read_ids(reader, piece.points, out, cells_.ghosts == 0,
             [](std::uint64_t value) { return value / 4; });
  }

  void check_tet_offsets(const ArrayReader& reader) const {
    for_each_integers(reader, [&](const Chunk& chunk, auto zero) {
      using T = decltype(zero);
      std::uint64_t differs = 0;
      for (std::uint64_t i = 0; i < chunk.count; ++i) {
        const std::uint64_t expected = 4 * (chunk.first + i + 1);
        differs |= static_cast<std::uint64_t>(load<T>(chunk.data, i)) ^ expected;
      }
      if (differs == 0) return;
      std::uint64_t i = 0;
      while (static_cast<std::uint64_t>(load<T>(chunk.data, i)) == 4 * (chunk.first + i + 1)) ++i;
      reader.fail(cell_name(chunk.first + i) + " is a tetrahedron and must end at " +
                  std::to_string(4 * (chunk.first + i + 1)) + ", not at " +
                  std::to_string(load<T>(chunk.data, i)) + reader.where(chunk.first + i));
    });
  }

  [[noreturn]] void wrong_length(const ArrayReader& reader, std::uint64_t expected) const {
    reader.fail("has " + std::to_string(reader.values()) + " values, but the cells end at " +
                std::to_string(expected));
  }

  // Checks vertex ids and writes them counted through all pieces. `cell_of` finds the cell of a
  // value, for the message.
  template <class CellOf>
  void read_ids(const ArrayReader& reader, std::uint64_t points, VertexId* out, bool mark_used,
                CellOf cell_of) {
    const VertexId base = static_cast<VertexId>(first_point_);
    std::uint8_t* const used = mark_used ? used_ : nullptr;
    for_each_integers(reader, [&](const Chunk& chunk, auto zero) {
      using T = decltype(zero);
      VertexId* const ids = out + chunk.first;
      std::uint64_t bad = 0;
      for (std::uint64_t i = 0; i < chunk.count; ++i) {
        // Negative ids are too large as unsigned ones.
        const std::uint64_t id = static_cast<std::uint64_t>(load<T>(chunk.data, i));
        bad |= id >= points ? 1 : 0;
        ids[i] = static_cast<VertexId>(id) + base;
      }
      if (bad != 0) fail_at_id<T>(reader, chunk, points, cell_of);
      if (used == nullptr) return;
      for (std::uint64_t i = 0; i < chunk.count; ++i) mark(used, ids[i]);
    });
  }

  template <class T, class CellOf>
  [[noreturn]] void fail_at_id(const ArrayReader& reader, const Chunk& chunk, std::uint64_t points,
                               CellOf cell_of) const {
    std::uint64_t i = 0;
    while (static_cast<std::uint64_t>(load<T>(chunk.data, i)) < points) ++i;
    const std::string id = std::to_string(load<T>(chunk.data, i));
    throw InvalidMesh(reader.message(cell_name(cell_of(chunk.first + i)) + " " +
                                     wrong_vertex(id, points) + reader.where(chunk.first + i)));
  }

  // After ghosts are known, so that points of ghost cells alone stay unused.
  void mark_tets() {
    for_each_block(cells_.tets.size(), kCellsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t c = begin; c < end; ++c) {
                       if (cells_.types[c] == VtuCells::kGhost) continue;
                       for (const VertexId v : cells_.tets[c]) mark(used_, v);
                     }
                   });
  }

  // ---- cells of all kinds ----

  void read_mixed(const VtuPiece& piece) {
    const std::uint64_t base = cells_.connectivity.size();
    std::uint64_t* const ends = cells_.offsets.data() + first_cell_ + 1;
    const ArrayReader offsets = open(piece.offsets, "offsets");
    for_each_integers(offsets, [&](const Chunk& chunk, auto zero) {
      using T = decltype(zero);
      for (std::uint64_t i = 0; i < chunk.count; ++i) {
        ends[chunk.first + i] = static_cast<std::uint64_t>(load<T>(chunk.data, i));
      }
    });
    const ArrayReader reader = open(piece.connectivity, "connectivity");
    check_cells(offsets, piece.cells, ends, reader.values());
    if (reader.values() != ends[piece.cells - 1]) wrong_length(reader, ends[piece.cells - 1]);
    cells_.connectivity.resize(base + reader.values());
    read_ids(reader, piece.points, cells_.connectivity.data() + base, false,
             [&](std::uint64_t value) {
               return static_cast<std::uint64_t>(std::upper_bound(ends, ends + piece.cells, value) -
                                                 ends);
             });
    for (std::uint64_t c = 0; c < piece.cells; ++c) ends[c] += base;
    mark_mixed(piece.cells);
  }

  // Every cell has as many vertices as its type wants and is of a kind that can be read.
  void check_cells(const ArrayReader& offsets, std::uint64_t cells, const std::uint64_t* ends,
                   std::uint64_t limit) const {
    const std::uint8_t* const types = cells_.types.data() + first_cell_;
    for_each_block(cells, kCellsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        const std::uint64_t first = c == 0 ? 0 : ends[c - 1];
        if (ends[c] < first || ends[c] > limit) {
          offsets.fail(cell_name(c) + " goes from " + std::to_string(first) + " to " +
                       std::to_string(static_cast<std::int64_t>(ends[c])) + ", but there are " +
                       std::to_string(limit) + " vertex ids" + offsets.where(c));
        }
        if (types[c] == VtuCells::kGhost) continue;
        if (kept_vertices(types[c], options_) < 0) fail(cell_name(c) + " " + refusal(types[c]));
        if (ends[c] - first != static_cast<std::uint64_t>(vtk_cell_size(types[c]))) {
          offsets.fail(cell_name(c) + " " + wrong_vertex_count(types[c], ends[c] - first) +
                       offsets.where(c));
        }
      }
    });
  }

  void mark_mixed(std::uint64_t cells) {
    for_each_block(cells, kCellsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t c = first_cell_ + begin; c < first_cell_ + end; ++c) {
        if (cells_.types[c] == VtuCells::kGhost) continue;
        const int kept = kept_vertices(cells_.types[c], options_);
        for (int k = 0; k < kept; ++k) {
          mark(used_, cells_.connectivity[cells_.offsets[c] + static_cast<std::uint64_t>(k)]);
        }
      }
    });
  }

  const VtuInput& input_;
  const OpenOptions& options_;
  std::uint8_t* used_;
  VtuCells cells_;
  std::size_t piece_ = 0;  // the piece being read, and what came before it
  std::uint64_t first_cell_ = 0;
  std::uint64_t first_point_ = 0;
};

}  // namespace

VtuCells read_cells(const VtuInput& input, const OpenOptions& options, Vector<std::uint8_t>* used) {
  return CellReader(input, options, used).run();
}

}  // namespace tetfusion
