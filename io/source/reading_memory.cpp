#include "io/source/reading_memory.h"

#include <algorithm>

#include "io/source/cell_kinds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// What threads have in hand while they read.
constexpr std::uint64_t kPassing = std::uint64_t{8} << 20;

std::uint64_t most_tets(std::uint8_t type) {
  switch (linear_type(type)) {
    case kVtkTetra:
      return 1;
    case kVtkPyramid:
      return 2;
    case kVtkWedge:
      return 3;
    case kVtkVoxel:
    case kVtkHexahedron:
      return 6;
    default:
      return 0;
  }
}

}  // namespace

std::uint64_t bytes_of(const AttributeSet& set) {
  std::uint64_t bytes = 0;
  for (const ArrayInfo& info : set.arrays) bytes += info.bytes();
  return bytes;
}

std::uint64_t memory_to_read(const MeshDescription& description, const CellTypeCounts& cells,
                             std::optional<std::uint64_t> ids_of_file) {
  std::uint64_t ids = ids_of_file.value_or(0);
  std::uint64_t tets = 0;
  std::uint64_t lower = 0;
  std::uint64_t all = 0;
  for (std::size_t t = 0; t < cells.size(); ++t) {
    const auto type = static_cast<std::uint8_t>(t);
    if (!ids_of_file) ids += cells[t] * corners_of(type);
    tets += cells[t] * most_tets(type);
    lower += most_tets(type) == 0 ? cells[t] : 0;
    all += cells[t];
  }
  const bool tets_only = cells[kVtkTetra] == all;
  const bool merges = description.joins_points;
  const std::uint64_t points = description.points;
  const std::uint64_t coordinates = points * 3 * size_of(description.point_type);

  // What is kept: rows of the file beside what was renumbered (Geometry's *_source).
  const std::uint64_t rows = tets_only ? 0 : 8 * tets;
  const std::uint64_t lower_bytes = lower * (1 + 8 + 8 + 3 * 4);
  const std::uint64_t geometry =
      coordinates + 16 * tets + rows + lower_bytes + (merges ? 8 * points : 0);
  // What the file has, as it is (FileCells), and a byte for each point: used or not.
  const std::uint64_t file = (tets_only ? 17 * all : 9 * all + 4 * ids) + points;
  // New numbers; and for the search for copies hashes, records and the copies' originals.
  const std::uint64_t merging = merges ? (4 + 8 + 16 + 4) * points : 0;
  // Tetrahedra of mixed cells are made block by block and then joined.
  const std::uint64_t taking = tets_only ? 0 : 24 * tets + 24 * tets / 2 + lower_bytes;
  const std::uint64_t making = coordinates + file + std::max(merging, taking);
  const std::uint64_t arrays = bytes_of(description.point_data) + bytes_of(description.cell_data);
  return std::max(making, geometry + arrays) + kPassing;
}

}  // namespace tetfusion
