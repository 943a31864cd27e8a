#include "kernel/boundary_triangles.h"

namespace tetfusion {

void BoundaryTriangles::begin(const FacingGrid& grid) {
  grid_ = &grid;
  triangles_.clear();
  asked_.clear();
  calls_ = 0;
  entries_.clear();
  first_.assign(grid.cells().size(), kNone);
  counts_.assign(grid.cells().size(), 0);
}

void BoundaryTriangles::note(const Corners& corners, const Triangle3& place) {
  add(corners, place);
  grid_->visit_triangle(place, [&](std::size_t cell) {
    ++counts_[cell];
    return false;
  });
}

void BoundaryTriangles::add(const Corners& corners, const Triangle3& place) {
  const auto triangle = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(corners);
  asked_.push_back(0);
  grid_->visit_triangle(place, [&](std::size_t cell) {
    const bool is_here = first_[cell] != kNone && entries_[first_[cell]].triangle == triangle;
    if (is_here) return false;
    entries_.push_back({triangle, first_[cell]});
    first_[cell] = static_cast<std::uint32_t>(entries_.size() - 1);
    return false;
  });
}

bool BoundaryTriangles::knows(const FacingBox& box) const {
  bool all = true;
  grid_->visit(box, [&](std::size_t cell) {
    all = counts_[cell] == grid_->count(cell);
    return !all;
  });
  return all;
}

}  // namespace tetfusion
