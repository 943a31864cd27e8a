// Cells that have the same values of some arrays have the same label.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"
#include "mesh/regions/region_numbers.h"

namespace tetfusion {

// Labels are small numbers, in the order in which values come.
class RegionLabels {
 public:
  // Arrays of the description's cell data: numbers of one component.
  RegionLabels(const MeshDescription& mesh, const std::vector<std::size_t>& cell_arrays);

  // One for each tetrahedron of a window that was read; valid until the next call.
  std::span<const std::uint32_t> read(const MeshStream& stream, std::uint64_t first,
                                      std::uint64_t count, const CellWindow& window);

 private:
  const MeshDescription& mesh_;
  std::vector<std::size_t> arrays_;
  std::vector<RegionNumbers> numbers_;  // of each array, inside the labels of those before it
  Vector<std::byte> bytes_;
  Vector<std::uint32_t> labels_;
};

}  // namespace tetfusion
