// Connectivity, offsets, types and ghost flags of one piece, read and checked a range at a time:
// what all that reads cells of a .vtu agrees on, messages too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"
#include "io/vtk/vtu_input.h"
#include "mesh/geometry.h"

namespace tetfusion {

class VtuCellArrays {
 public:
  // Opens nothing yet. `input` outlives this.
  VtuCellArrays(const VtuInput& input, std::size_t piece) : input_(&input), piece_(piece) {}

  // The types; and, where Lagrange cells are met, what says of which order they are.
  struct TypeArray {
    struct Offsets {
      std::once_flag once;
      std::optional<ArrayReader> reader;
    };
    ArrayReader reader;
    std::shared_ptr<Offsets> offsets;
  };
  TypeArray open_types() const;
  ArrayReader open_offsets() const;
  ArrayReader open_connectivity() const;

  struct GhostArray {
    ArrayReader reader;
    bool levels = false;  // vtkGhostLevels, not the flags of vtkGhostType
  };
  std::vector<GhostArray> open_ghosts() const;  // none, one or both

  // Ranges of cells from `first` on; everything throws Error(kBadInput) naming the first cell that
  // is not right, counted from the piece's start, unless it says something else.

  // As settled_type() has them.
  void read_types(const TypeArray& types, std::uint64_t first, std::uint64_t count,
                  std::uint8_t* out) const;

  // Overwrites the types of ghost cells with kLeftOut. Returns how many had others before.
  std::uint64_t mark_ghosts(const std::vector<GhostArray>& ghosts, std::uint64_t first,
                            std::uint64_t count, std::uint8_t* types) const;

  // In a mesh of tetrahedra alone, cell c ends at 4 * (c + 1). Looks at all of them.
  void check_tet_offsets(const ArrayReader& offsets) const;

  // ends[0] is where the first cell begins, ends[i + 1] where cell first + i ends. Not checked.
  void read_ends(const ArrayReader& offsets, std::uint64_t first, std::uint64_t count,
                 std::uint64_t* ends) const;

  // Cells of all kinds: every one lies within `limit` vertex ids and, unless it is left out, has as
  // many as its type wants and is of a kind that can be read. `ends` as from read_ends().
  void check_cells(const ArrayReader& offsets, const OpenOptions& options, std::uint64_t first,
                   std::uint64_t count, const std::uint8_t* types, const std::uint64_t* ends,
                   std::uint64_t limit) const;

  // The cells end at `expected`: the connectivity has so many values.
  void check_length(const ArrayReader& connectivity, std::uint64_t expected) const;

  // `count` vertex ids, `base` added to each; `used`, where not nullptr, gets a byte set for each
  // vertex (with `base`). `cell_of` finds the cell of a value, for the message. Throws InvalidMesh.
  struct IdRange {
    std::uint64_t first = 0;  // value of the connectivity
    std::uint64_t count = 0;
    VertexId base = 0;
  };
  void read_ids(const ArrayReader& connectivity, const IdRange& range,
                const std::function<std::uint64_t(std::uint64_t)>& cell_of, std::uint8_t* used,
                VertexId* out) const;

  [[noreturn]] void refuse(std::uint64_t cell, std::uint8_t type, const OpenOptions& options) const;

 private:
  const VtuPiece& piece() const { return input_->head.pieces[piece_]; }
  ArrayReader open(const VtuArray& array, const std::string& name) const;
  std::string cell_name(std::uint64_t cell) const;
  void settle_types(const TypeArray& types, std::uint64_t first, std::uint64_t count,
                    std::uint8_t* out) const;

  const VtuInput* input_;
  std::size_t piece_;
};

}  // namespace tetfusion
