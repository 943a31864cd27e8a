// Cells that have the same values of some integer arrays have the same label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/vector.h"
#include "io/mesh_source.h"
#include "io/mesh_stream.h"

namespace tetfusion {

// Labels are small numbers, in the order in which values come.
class RegionLabels {
 public:
  // Arrays of the description's cell data: integers of one component.
  RegionLabels(const MeshDescription& mesh, const std::vector<std::size_t>& cell_arrays);

  // One for each tetrahedron of a window that was read; valid until the next call.
  std::span<const std::uint32_t> read(const MeshStream& stream, std::uint64_t first,
                                      std::uint64_t count, const CellWindow& window);

 private:
  void refine(const ArrayInfo& info, std::uint64_t first, const CellWindow& window);

  const MeshDescription& mesh_;
  std::vector<std::size_t> arrays_;
  // For each array, from the label of the arrays before it and its own value.
  std::vector<std::map<std::pair<std::uint32_t, std::int64_t>, std::uint32_t>> numbers_;
  std::size_t array_ = 0;  // in hand
  Vector<std::byte> bytes_;
  Vector<std::uint32_t> labels_;
};

}  // namespace tetfusion
