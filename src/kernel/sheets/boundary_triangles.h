// The triangles of the boundary of a mesh, or of a chunk of one, while it is worked on: what a part
// of the boundary that rises would meet. A grid (facing_grid.h) has counted those of all chunks in
// its cells, so that it is known where all of them are here. They are found by cells that are four,
// sixteen or 64 of the grid's long, along each axis by itself, so that each triangle is in eight at
// most: those of a rod are as wide as the grid, which has as many layers everywhere.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "kernel/sheets/facing_grid.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Keeps its memory from mesh to mesh. Not thread-safe.
class BoundaryTriangles {
 public:
  using Corners = std::array<VertexId, 3>;

  // The grid has noted what the boundary is at the beginning of the round; it outlives this.
  void begin(const FacingGrid& grid);
  // Each triangle once, with its place, and none that the grid has not noted.
  void note(const Corners& corners, const Triangle3& place);
  // One that has come since, or whose corners have moved. Nobody says which are gone.
  void add(const Corners& corners, const Triangle3& place);

  // Whether all triangles in the cells that the box touches were here when the round began.
  bool knows(const FacingBox& box) const;
  // Calls use(corners) with each that may touch the box, until it says true; whether it did.
  template <class Use>
  bool any(const FacingBox& box, Use use);
  // In how many cells the triangles are, all together.
  std::size_t entries() const { return entries_.size(); }

 private:
  struct Entry {
    std::uint32_t triangle;
    std::uint32_t next;  // in its cell
  };
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  // How long cells are along an axis, as powers of four, and where those of each length begin.
  static constexpr unsigned kLengths = 4;
  static constexpr std::array<std::size_t, kLengths + 1> kBegin{0, 64, 80, 84, 85};
  static constexpr std::size_t kRow = kBegin[kLengths];
  static_assert(kBegin[1] == FacingGrid::kCells);
  using Shape = std::array<unsigned, 3>;
  static unsigned bit_of(const Shape& shape) {
    return (shape[2] * kLengths + shape[1]) * kLengths + shape[0];
  }
  static Shape shape_of(const FacingGrid::Range& range);
  // Calls visit(cell) with those of this shape in the range, until it says true; whether it did.
  template <class Visit>
  static bool visit(FacingGrid::Range range, const Shape& shape, Visit visit);

  const FacingGrid* grid_ = nullptr;
  Vector<Corners> triangles_;
  Vector<std::uint32_t> asked_;  // of each: the last call of any() that has come across it
  std::uint32_t calls_ = 0;
  Vector<Entry> entries_;
  Vector<std::uint32_t> first_;   // entry of each cell
  std::uint64_t shapes_ = 0;      // that have entries, a bit each
  Vector<std::uint32_t> counts_;  // of entries, when the round began
};

template <class Visit>
bool BoundaryTriangles::visit(FacingGrid::Range range, const Shape& shape, Visit visit) {
  for (std::size_t i = 0; i < 3; ++i) {
    range.first[i] = kBegin[shape[i]] + (range.first[i] >> 2 * shape[i]);
    range.last[i] = kBegin[shape[i]] + (range.last[i] >> 2 * shape[i]);
  }
  return FacingGrid::visit_range<kRow>(range, visit);
}

template <class Use>
bool BoundaryTriangles::any(const FacingBox& box, Use use) {
  const FacingGrid::Range range = grid_->range_of(box);
  if (range.count() > triangles_.size()) {
    return std::any_of(triangles_.begin(), triangles_.end(), use);
  }
  ++calls_;
  for (std::uint64_t left = shapes_; left != 0; left &= left - 1) {
    const auto bit = static_cast<unsigned>(std::countr_zero(left));
    const Shape shape{bit % kLengths, bit / kLengths % kLengths, bit / kLengths / kLengths};
    const bool found = visit(range, shape, [&](std::size_t cell) {
      for (std::uint32_t e = first_[cell]; e != kNone; e = entries_[e].next) {
        const std::uint32_t t = entries_[e].triangle;
        if (asked_[t] == calls_) continue;
        asked_[t] = calls_;
        if (use(triangles_[t])) return true;
      }
      return false;
    });
    if (found) return true;
  }
  return false;
}

}  // namespace tetfusion
