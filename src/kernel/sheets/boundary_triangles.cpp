#include "kernel/sheets/boundary_triangles.h"

namespace tetfusion {

void BoundaryTriangles::begin(const FacingGrid& grid) {
  grid_ = &grid;
  triangles_.clear();
  asked_.clear();
  calls_ = 0;
  entries_.clear();
  first_.assign(kRow * kRow * kRow, kNone);
  shapes_ = 0;
  counts_.assign(grid.cells().size(), 0);
}

void BoundaryTriangles::note(const Corners& corners, const Triangle3& place) {
  add(corners, place);
  grid_->visit_triangle(place, [&](std::size_t cell) {
    ++counts_[cell];
    return false;
  });
}

// The shortest of which it touches two along each axis.
auto BoundaryTriangles::shape_of(const FacingGrid::Range& range) -> Shape {
  Shape shape{};
  for (std::size_t i = 0; i < 3; ++i) {
    while ((range.last[i] >> 2 * shape[i]) - (range.first[i] >> 2 * shape[i]) > 1) ++shape[i];
  }
  return shape;
}

void BoundaryTriangles::add(const Corners& corners, const Triangle3& place) {
  const auto triangle = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back(corners);
  asked_.push_back(0);
  const FacingGrid::Range range = grid_->range_of(box_round(place[0], place[1], place[2]));
  const Shape shape = shape_of(range);
  shapes_ |= std::uint64_t{1} << bit_of(shape);
  visit(range, shape, [&](std::size_t cell) {
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
