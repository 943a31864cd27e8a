#include "io/source/view_stream.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/bit_set.h"
#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/cell_windows.h"
#include "io/source/view_cells.h"

namespace tetfusion {

namespace {

class ViewStream final : public MeshStream {
 public:
  ViewStream(const MeshView& view, const MeshDescription& description, const OpenOptions& options)
      : view_(view), description_(description), cells_(view, options) {
    find_bad_points();
    if (cells_.ghosts() > 0) {
      beside_ghosts_.resize(points());
      cells_.for_each_vertex(true, [&](VertexId v) { beside_ghosts_.set(v); });
    }
    if (!cells_.as_they_are()) take_used_points();
  }

  std::uint64_t points() const override {
    return sources_.empty() ? description_.points : sources_.size();
  }
  std::uint64_t cells() const override {
    return cells_.as_they_are() ? cells_.size() : taken_.tets.size() + taken_.lower.size();
  }
  LowerCount lower_cells() const override {
    if (cells_.as_they_are()) return cells_.lower();
    return {taken_.lower.size(), taken_.lower.connectivity.size()};
  }
  std::uint64_t ghost_cells() const override { return cells_.ghosts(); }
  std::uint64_t merged_points() const override { return 0; }
  std::uint64_t dropped_points() const override { return description_.points - points(); }
  bool streams_from_disk() const override { return false; }
  std::uint64_t bytes() const override {
    const std::uint64_t lower = taken_.lower.connectivity.size() * sizeof(VertexId) +
                                taken_.lower.size() * (1 + 2 * sizeof(std::uint64_t));
    return bad_points_.bytes() + beside_ghosts_.bytes() + lower +
           sources_.size() * sizeof(VertexId) +
           taken_.tets.size() * (sizeof(Tet) + sizeof(std::uint64_t));
  }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    check_window(first, count, points());
    copy_points(view_.points, 3, first, count, out.data());
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    check_window(first, count, cells());
    if (cells_.as_they_are()) {
      cells_.read(first, count, out);
    } else {
      read_taken(first, count, out);
    }
    if (!bad_points_.empty()) check_finite(*out);
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    const bool of_points = association == Association::kPoint;
    check_window(first, count, of_points ? points() : cells());
    const ArrayView& array = (of_points ? view_.point_arrays : view_.cell_arrays).at(index);
    if (of_points) {
      copy_points(array.values, array.components, first, count, out.data());
    } else if (cells_.as_they_are()) {
      copy_tuples(array.values, array.components, first, count, out.data());
    } else {
      const std::size_t tuple = array.components * size_of(array.values.type);
      for (std::uint64_t i = 0; i < count; ++i) {
        copy_tuples(array.values, array.components, cell_of(first + i), 1, out.data() + i * tuple);
      }
    }
    const AttributeSet& set = of_points ? description_.point_data : description_.cell_data;
    const ArrayInfo& info = set.arrays[index];
    forget_ghosts(association, info, out.first(count * info.row_bytes()));
  }

  void read_locks(std::uint64_t first, std::uint64_t count, std::uint8_t* locked) const override {
    check_window(first, count, points());
    if (beside_ghosts_.empty()) return;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (beside_ghosts_.has(source_of(first + i))) locked[i] = 1;
    }
  }

 private:
  static void copy_tuples(const ValuesView& values, std::uint64_t components, std::uint64_t first,
                          std::uint64_t count, std::byte* out) {
    const std::uint64_t tuple = components * size_of(values.type);
    if (count > 0) std::memcpy(out, values.bytes.data() + first * tuple, count * tuple);
  }

  void copy_points(const ValuesView& values, std::uint64_t components, std::uint64_t first,
                   std::uint64_t count, std::byte* out) const {
    if (sources_.empty()) return copy_tuples(values, components, first, count, out);
    const std::uint64_t tuple = components * size_of(values.type);
    for (std::uint64_t i = 0; i < count; ++i) {
      copy_tuples(values, components, sources_[first + i], 1, out + i * tuple);
    }
  }

  std::uint64_t source_of(std::uint64_t point) const {
    return sources_.empty() ? point : sources_[point];
  }

  // As a file is read whose cells are to be split or linearized.
  void take_used_points() {
    Vector<VertexId> number;
    number.assign(description_.points, kNoVertex);
    cells_.for_each_vertex(false, [&](VertexId v) { number[v] = 0; });
    for (VertexId v = 0; v < number.size(); ++v) {
      if (number[v] == kNoVertex) continue;
      number[v] = static_cast<VertexId>(sources_.size());
      sources_.push_back(v);
    }
    if (sources_.size() == number.size()) sources_ = number = {};
    take_cells(view_.name, cells_.all(), number, &taken_);
  }

  void find_bad_points() {
    visit_type(view_.points.type, [&](auto zero) {
      using Real = decltype(zero);
      const auto* x = reinterpret_cast<const Real*>(view_.points.bytes.data());
      for (std::uint64_t k = 0; k < 3 * points(); ++k) {
        if (std::isfinite(static_cast<double>(x[k]))) continue;
        if (bad_points_.empty()) bad_points_.resize(points());
        bad_points_.set(k / 3);
      }
    });
  }

  // Throws InvalidMesh for the lowest point of a cell that is not finite.
  void check_finite(const CellWindow& window) const {
    const VertexId lowest =
        lowest_vertex(window, [&](VertexId v) { return bad_points_.has(source_of(v)); });
    if (lowest == kNoVertex) return;
    throw InvalidMesh(view_.name + ": point " + std::to_string(source_of(lowest)) +
                      " has a coordinate that is not finite");
  }

  // Tetrahedra first, then the cells of lower dimension: a cell's number is its row.
  void read_taken(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
    *out = {};
    if (first == 0) out->ghost_cells = cells_.ghosts();
    const std::uint64_t tets = taken_.tets.size();
    const std::uint64_t last = first + count;
    if (first < tets) {
      const Tet* const from = taken_.tets.data();
      out->tets.assign(from + first, from + std::min(last, tets));
    }
    const LowerCells& lower = taken_.lower;
    for (std::uint64_t cell = std::max(first, tets); cell < last; ++cell) {
      out->lower.add(lower.types[cell - tets], lower.corners(cell - tets));
      out->lower_rows.push_back(cell);
    }
  }

  // Of the view, where cells were taken.
  std::uint64_t cell_of(std::uint64_t row) const {
    const std::uint64_t tets = taken_.tets.size();
    const auto look_up = [](const Vector<std::uint64_t>& source, std::uint64_t i) {
      return source.empty() ? i : source[i];
    };
    return row < tets ? look_up(taken_.tet_source, row) : look_up(taken_.lower_source, row - tets);
  }

  const MeshView& view_;
  const MeshDescription& description_;
  ViewCells cells_;
  BitSet bad_points_;     // empty: all are finite
  BitSet beside_ghosts_;  // points of ghost cells; empty: there are none
  Geometry taken_;        // where cells are split or linearized: without points
  // Of each point its number in the view, where cells are split or linearized and some points are
  // not used then; else empty.
  Vector<VertexId> sources_;
};

}  // namespace

std::unique_ptr<MeshStream> open_view_stream(const MeshView& view,
                                             const MeshDescription& description,
                                             const OpenOptions& options) {
  return std::make_unique<ViewStream>(view, description, options);
}

}  // namespace tetfusion
