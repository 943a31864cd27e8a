#include "io/vtk/vtu_cell_arrays.h"

#include <cstring>
#include <type_traits>

#include "base/blocks.h"
#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/file_cells.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

template <class T>
T load(const std::byte* bytes, std::size_t index) {
  T value;
  std::memcpy(&value, bytes + index * sizeof(T), sizeof(T));
  return value;
}

// Calls f(chunk, T{}) for each chunk of a range of an integer array, T its type.
template <class F>
void for_each_integers(const ArrayReader& reader, std::uint64_t first, std::uint64_t count, F f) {
  visit_type(reader.type(), [&](auto zero) {
    if constexpr (std::is_integral_v<decltype(zero)>) {
      reader.for_each_chunk(first, count, [&](const Chunk& chunk) { f(chunk, zero); });
    }
  });
}

}  // namespace

// ---- Opening ----

ArrayReader VtuCellArrays::open(const VtuArray& array, const std::string& name) const {
  return input_->open(array, "cell array \"" + name + "\"" + input_->of_piece(piece_));
}

VtuCellArrays::TypeArray VtuCellArrays::open_types() const {
  return {open(piece().types, "types"), std::make_shared<TypeArray::Offsets>()};
}
ArrayReader VtuCellArrays::open_offsets() const { return open(piece().offsets, "offsets"); }
ArrayReader VtuCellArrays::open_connectivity() const {
  return open(piece().connectivity, "connectivity");
}

std::vector<VtuCellArrays::GhostArray> VtuCellArrays::open_ghosts() const {
  std::vector<GhostArray> ghosts;
  const AttributeSet& data = input_->head.cell_data;
  for (const bool levels : {false, true}) {
    const char* name = levels ? "vtkGhostLevels" : "vtkGhostType";
    const std::size_t index = data.find(name);
    if (index == AttributeSet::npos || is_float(data.arrays[index].type) ||
        data.arrays[index].components != 1) {
      continue;
    }
    ghosts.push_back({open(piece().cell_data[index], name), levels});
  }
  return ghosts;
}

// ---- Types ----

// Cells are numbered within their piece.
std::string VtuCellArrays::cell_name(std::uint64_t cell) const {
  return "cell " + std::to_string(cell) + input_->of_piece(piece_);
}

void VtuCellArrays::refuse(std::uint64_t cell, std::uint8_t type,
                           const OpenOptions& options) const {
  input_->fail(ErrorCode::kBadInput, cell_name(cell) + " " + refusal(type, options));
}

void VtuCellArrays::read_types(const TypeArray& types, std::uint64_t first, std::uint64_t count,
                               std::uint8_t* out) const {
  std::atomic<bool> any_to_settle = false;
  for_each_integers(types.reader, first, count, [&](const Chunk& chunk, auto zero) {
    using T = decltype(zero);
    std::uint8_t* const to = out + (chunk.first - first);
    for (std::uint64_t i = 0; i < chunk.count; ++i) {
      const T type = load<T>(chunk.data, i);
      // As unsigned, so that negative ones are too large.
      if (static_cast<std::uint64_t>(type) >= kLeftOut) {
        input_->fail(ErrorCode::kBadInput, cell_name(chunk.first + i) + " has the type " +
                                               std::to_string(type) + ", which VTK does not have" +
                                               types.reader.where(chunk.first + i));
      }
      to[i] = static_cast<std::uint8_t>(type);
      if (is_of_any_order(to[i])) any_to_settle.store(true, std::memory_order_relaxed);
    }
  });
  if (any_to_settle) settle_types(types, first, count, out);
}

void VtuCellArrays::settle_types(const TypeArray& types, std::uint64_t first, std::uint64_t count,
                                 std::uint8_t* out) const {
  std::call_once(types.offsets->once, [&] { types.offsets->reader.emplace(open_offsets()); });
  Vector<std::uint64_t> ends(count + 1);
  read_ends(*types.offsets->reader, first, count, ends.data());
  for (std::uint64_t i = 0; i < count; ++i) {
    out[i] = settled_type(out[i], ends[i + 1] - ends[i]);
  }
}

std::uint64_t VtuCellArrays::mark_ghosts(const std::vector<GhostArray>& ghosts, std::uint64_t first,
                                         std::uint64_t count, std::uint8_t* types) const {
  std::atomic<std::uint64_t> marked = 0;
  for (const GhostArray& ghost : ghosts) {
    const bool levels = ghost.levels;
    for_each_integers(ghost.reader, first, count, [&](const Chunk& chunk, auto zero) {
      using T = decltype(zero);
      std::uint8_t* const to = types + (chunk.first - first);
      std::uint64_t fresh = 0;
      for (std::uint64_t i = 0; i < chunk.count; ++i) {
        const T value = load<T>(chunk.data, i);
        if (levels ? value <= 0 : (value & T{kGhostDropped}) == 0) continue;
        fresh += to[i] != kLeftOut ? 1 : 0;
        to[i] = kLeftOut;
      }
      marked += fresh;
    });
  }
  return marked;
}

// ---- Offsets ----

void VtuCellArrays::check_tet_offsets(const ArrayReader& offsets) const {
  for_each_integers(offsets, 0, offsets.values(), [&](const Chunk& chunk, auto zero) {
    using T = decltype(zero);
    std::uint64_t differs = 0;
    for (std::uint64_t i = 0; i < chunk.count; ++i) {
      const std::uint64_t expected = 4 * (chunk.first + i + 1);
      differs |= static_cast<std::uint64_t>(load<T>(chunk.data, i)) ^ expected;
    }
    if (differs == 0) return;
    std::uint64_t i = 0;
    while (static_cast<std::uint64_t>(load<T>(chunk.data, i)) == 4 * (chunk.first + i + 1)) ++i;
    offsets.fail(cell_name(chunk.first + i) + " is a tetrahedron and must end at " +
                 std::to_string(4 * (chunk.first + i + 1)) + ", not at " +
                 std::to_string(load<T>(chunk.data, i)) + offsets.where(chunk.first + i));
  });
}

void VtuCellArrays::read_ends(const ArrayReader& offsets, std::uint64_t first, std::uint64_t count,
                              std::uint64_t* ends) const {
  const std::uint64_t before = first == 0 ? 0 : 1;
  if (before == 0) ends[0] = 0;
  std::uint64_t* const out = ends + 1 - before;
  first -= before;
  for_each_integers(offsets, first, count + before, [&](const Chunk& chunk, auto zero) {
    using T = decltype(zero);
    for (std::uint64_t i = 0; i < chunk.count; ++i) {
      out[chunk.first - first + i] = static_cast<std::uint64_t>(load<T>(chunk.data, i));
    }
  });
}

void VtuCellArrays::check_cells(const ArrayReader& offsets, const OpenOptions& options,
                                std::uint64_t first, std::uint64_t count, const std::uint8_t* types,
                                const std::uint64_t* ends, std::uint64_t limit) const {
  for_each_block(count, kCellsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint64_t cell = first + i;
      if (ends[i + 1] < ends[i] || ends[i + 1] > limit) {
        offsets.fail(cell_name(cell) + " goes from " + std::to_string(ends[i]) + " to " +
                     std::to_string(static_cast<std::int64_t>(ends[i + 1])) + ", but there are " +
                     std::to_string(limit) + " vertex ids" + offsets.where(cell));
      }
      if (types[i] == kLeftOut) continue;
      if (kept_vertices(types[i], options) < 0) refuse(cell, types[i], options);
      const std::uint64_t vertices = ends[i + 1] - ends[i];
      if (!may_have_vertices(types[i], vertices)) {
        offsets.fail(cell_name(cell) + " " + wrong_vertex_count(types[i], vertices) +
                     offsets.where(cell));
      }
    }
  });
}

// ---- Connectivity ----

void VtuCellArrays::check_length(const ArrayReader& connectivity, std::uint64_t expected) const {
  if (connectivity.values() == expected) return;
  connectivity.fail("has " + std::to_string(connectivity.values()) +
                    " values, but the cells end at " + std::to_string(expected));
}

void VtuCellArrays::read_ids(const ArrayReader& connectivity, const IdRange& range,
                             const std::function<std::uint64_t(std::uint64_t)>& cell_of,
                             std::uint8_t* used, VertexId* out) const {
  const std::uint64_t points = piece().points;
  for_each_integers(connectivity, range.first, range.count, [&](const Chunk& chunk, auto zero) {
    using T = decltype(zero);
    VertexId* const ids = out + (chunk.first - range.first);
    std::uint64_t bad = 0;
    for (std::uint64_t i = 0; i < chunk.count; ++i) {
      // Negative ids are too large as unsigned ones.
      const std::uint64_t id = static_cast<std::uint64_t>(load<T>(chunk.data, i));
      bad |= id >= points ? 1 : 0;
      ids[i] = static_cast<VertexId>(id) + range.base;
    }
    if (bad != 0) {
      std::uint64_t i = 0;
      while (static_cast<std::uint64_t>(load<T>(chunk.data, i)) < points) ++i;
      const std::uint64_t at = chunk.first + i;
      const std::string id = std::to_string(load<T>(chunk.data, i));
      throw InvalidMesh(connectivity.message(cell_name(cell_of(at)) + " " +
                                             wrong_vertex(id, points) + connectivity.where(at)));
    }
    if (used == nullptr) return;
    for (std::uint64_t i = 0; i < chunk.count; ++i) mark_used(used, ids[i]);
  });
}

}  // namespace tetfusion
