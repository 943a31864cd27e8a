#include "mesh/inspection/vertex_ranges.h"

#include <array>

#include "base/blocks.h"

namespace tetfusion {

namespace {

constexpr std::size_t kLeastBlock = 1 << 16;  // cells
constexpr std::size_t kMostBlocks = 256;      // a table of blocks * ranges is made

// Calls f(range) for each range that a vertex of the cell is in.
template <class F>
void for_each_range(const Tet& t, F f) {
  std::array<VertexId, 4> ranges{};
  for (std::size_t k = 0; k < 4; ++k) ranges[k] = t[k] / CellsByRange::kRangeVertices;
  f(ranges[0]);
  if (ranges[1] != ranges[0]) f(ranges[1]);
  if (ranges[2] != ranges[0] && ranges[2] != ranges[1]) f(ranges[2]);
  if (ranges[3] != ranges[0] && ranges[3] != ranges[1] && ranges[3] != ranges[2]) f(ranges[3]);
}

}  // namespace

CellsByRange::CellsByRange(std::size_t vertices, std::span<const Tet> tets) {
  const std::size_t ranges = block_count(vertices, kRangeVertices);
  const std::size_t block = std::max(kLeastBlock, block_count(tets.size(), kMostBlocks));
  const std::size_t blocks = block_count(tets.size(), block);
  Vector<std::uint64_t> places(blocks * ranges, 0);  // counts, then where to put the next cell
  for_each_block(tets.size(), block, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::uint64_t* const counts = places.data() + b * ranges;
    for (std::size_t t = begin; t < end; ++t) {
      for_each_range(tets[t], [&](VertexId range) { ++counts[range]; });
    }
  });
  offsets_.resize(ranges + 1);
  std::uint64_t sum = 0;
  for (std::size_t r = 0; r < ranges; ++r) {
    offsets_[r] = sum;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::uint64_t count = places[b * ranges + r];
      places[b * ranges + r] = sum;
      sum += count;
    }
  }
  offsets_[ranges] = sum;
  cells_.resize(sum);
  for_each_block(tets.size(), block, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::uint64_t* const at = places.data() + b * ranges;
    for (std::size_t t = begin; t < end; ++t) {
      for_each_range(tets[t], [&](VertexId range) { cells_[at[range]++] = static_cast<TetId>(t); });
    }
  });
}

}  // namespace tetfusion
