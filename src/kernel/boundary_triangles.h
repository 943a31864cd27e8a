// The triangles of the boundary of a mesh, or of a chunk of one, while it is worked on: what a part
// of the boundary that rises would meet. By the cells of a grid (facing_grid.h) that has counted
// those of all chunks, so that it is known where all of them are here.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "kernel/facing_grid.h"
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

 private:
  struct Entry {
    std::uint32_t triangle;
    std::uint32_t next;  // in its cell
  };
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  const FacingGrid* grid_ = nullptr;
  Vector<Corners> triangles_;
  Vector<std::uint32_t> asked_;  // of each: the last call of any() that has come across it
  std::uint32_t calls_ = 0;
  Vector<Entry> entries_;
  Vector<std::uint32_t> first_;   // entry of each cell
  Vector<std::uint32_t> counts_;  // of entries, when the round began
};

template <class Use>
bool BoundaryTriangles::any(const FacingBox& box, Use use) {
  if (grid_->cells_in(box) > triangles_.size()) {
    return std::any_of(triangles_.begin(), triangles_.end(), use);
  }
  ++calls_;
  bool found = false;
  grid_->visit(box, [&](std::size_t cell) {
    for (std::uint32_t e = first_[cell]; e != kNone && !found; e = entries_[e].next) {
      const std::uint32_t t = entries_[e].triangle;
      if (asked_[t] == calls_) continue;
      asked_[t] = calls_;
      found = use(triangles_[t]);
    }
    return found;
  });
  return found;
}

}  // namespace tetfusion
