// The cells of a mesh that lies in memory: checked once, then read in windows or all at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/source/cell_kinds.h"
#include "io/source/file_cells.h"
#include "io/source/mesh_stream.h"
#include "io/source/mesh_view.h"

namespace tetfusion {

class ViewCells {
 public:
  // Looks at all cells, ghosts too. Throws Error(kBadInput) naming the first one that is not right,
  // InvalidMesh for an id out of range, Error(kMemory) for too many points or tetrahedra. The view
  // and the options outlive this.
  ViewCells(const MeshView& view, const OpenOptions& options);

  std::uint64_t size() const { return view_.cells(); }
  std::uint64_t ghosts() const { return ghosts_; }
  const LowerCount& lower() const { return lower_; }  // as they are in the view
  bool as_they_are() const { return as_they_are_; }   // none is to be split or linearized

  // Replaces *out, whose memory stays. REQUIRES: as_they_are(), and cells that are there.
  void read(std::uint64_t first, std::uint64_t count, CellWindow* out) const;

  // All of them, for take_cells().
  FileCells all() const;

  // Calls f(v) for every vertex that is kept of the cells that stay; of ghost cells for all.
  template <class F>
  void for_each_vertex(bool of_ghosts, F f) const;

 private:
  template <class Id>
  void look_at_all();
  template <class Id>
  void look_at(std::uint64_t cell);
  template <class Id>
  void read_as(std::uint64_t first, std::uint64_t count, CellWindow* out) const;

  bool is_wide() const { return view_.connectivity.type == ValueType::kInt64; }
  bool is_ghost(std::uint64_t cell) const;
  bool is_left_out(std::uint64_t cell) const;  // a ghost cell, or a patch's that is dropped
  std::uint8_t type_of(std::uint64_t cell) const;
  // Where in the connectivity a cell begins; that of the cell behind the last one is the end.
  template <class Id>
  std::uint64_t begin_of(std::uint64_t cell) const {
    return view_.tets_only ? 4 * cell
                           : static_cast<std::uint64_t>(numbers<Id>(view_.offsets)[cell]);
  }
  template <class Id>
  std::uint64_t ids_of(std::uint64_t cell) const {
    return begin_of<Id>(cell + 1) - begin_of<Id>(cell);
  }
  template <class Id>
  static std::span<const Id> numbers(const ValuesView& values) {
    return {reinterpret_cast<const Id*>(values.bytes.data()), values.size()};
  }
  [[noreturn]] void fail(std::uint64_t cell, const std::string& what) const;

  const MeshView& view_;
  const OpenOptions& options_;
  std::uint64_t points_ = 0;
  std::uint64_t ghosts_ = 0;
  std::uint64_t tets_ = 0;
  LowerCount lower_;
  bool as_they_are_ = true;
};

template <class F>
void ViewCells::for_each_vertex(bool of_ghosts, F f) const {
  const auto visit = [&](auto zero) {
    using Id = decltype(zero);
    const std::span<const Id> ids = numbers<Id>(view_.connectivity);
    for (std::uint64_t c = 0; c < size(); ++c) {
      if (is_ghost(c) != of_ghosts) continue;
      const std::uint64_t begin = begin_of<Id>(c);
      const std::uint64_t kept =
          of_ghosts ? begin_of<Id>(c + 1) - begin
                    : static_cast<std::uint64_t>(kept_vertices(type_of(c), options_));
      for (std::uint64_t k = begin; k < begin + kept; ++k) f(static_cast<VertexId>(ids[k]));
    }
  };
  is_wide() ? visit(std::int64_t{}) : visit(std::int32_t{});
}

}  // namespace tetfusion
