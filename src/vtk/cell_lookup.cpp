#include "vtk/cell_lookup.h"

#include <vtkIdList.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tetfusion {
namespace {

// The points of one cell, ascending.
class SortedCells {
 public:
  explicit SortedCells(vtkCellArray* cells) : cells_(cells) {}

  const std::vector<vtkIdType>& points(vtkIdType cell) {
    cells_->GetCellAtId(cell, list_);
    points_.assign(list_->begin(), list_->end());
    std::sort(points_.begin(), points_.end());
    return points_;
  }

  // Cells with the same points have the same one.
  std::uint64_t mark(vtkIdType cell) {
    std::uint64_t mark = 0;
    for (const vtkIdType point : points(cell)) {
      mark = (mark ^ static_cast<std::uint64_t>(point)) * 0x9E3779B97F4A7C15U;
      mark ^= mark >> 29;
    }
    return mark;
  }

 private:
  vtkCellArray* cells_;
  vtkNew<vtkIdList> list_;
  std::vector<vtkIdType> points_;
};

// Is there a cell of each type that is wanted?
bool have_types(vtkUnsignedCharArray* among, vtkUnsignedCharArray* wanted) {
  std::array<bool, 256> known{};
  for (vtkIdType c = 0; c < among->GetNumberOfTuples(); ++c) known[among->GetValue(c)] = true;
  for (vtkIdType c = 0; c < wanted->GetNumberOfTuples(); ++c) {
    if (!known[wanted->GetValue(c)]) return false;
  }
  return true;
}

}  // namespace

std::vector<vtkIdType> find_cells(vtkCellArray* among, vtkUnsignedCharArray* types_among,
                                  vtkCellArray* wanted, vtkUnsignedCharArray* types_wanted) {
  const vtkIdType known = among->GetNumberOfCells();
  const vtkIdType count = wanted->GetNumberOfCells();
  if (count > known || !have_types(types_among, types_wanted)) return {};
  SortedCells sorted(among), sorted_wanted(wanted);
  std::vector<std::pair<std::uint64_t, vtkIdType>> marks;
  marks.reserve(static_cast<std::size_t>(known));
  for (vtkIdType c = 0; c < known; ++c) marks.emplace_back(sorted.mark(c), c);
  std::sort(marks.begin(), marks.end());
  std::vector<bool> is_taken(static_cast<std::size_t>(known));
  std::vector<vtkIdType> found;
  found.reserve(static_cast<std::size_t>(count));
  for (vtkIdType c = 0; c < count; ++c) {
    const std::pair first(sorted_wanted.mark(c), vtkIdType{0});
    auto at = std::lower_bound(marks.begin(), marks.end(), first);
    while (at != marks.end() && at->first == first.first &&
           (is_taken[static_cast<std::size_t>(at->second)] ||
            types_among->GetValue(at->second) != types_wanted->GetValue(c) ||
            sorted.points(at->second) != sorted_wanted.points(c))) {
      ++at;
    }
    if (at == marks.end() || at->first != first.first) return {};
    is_taken[static_cast<std::size_t>(at->second)] = true;
    found.push_back(at->second);
  }
  return found;
}

}  // namespace tetfusion
