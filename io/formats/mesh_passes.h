// A mesh gone through from its first point to its last cell, as often as a writer needs it: in
// windows, and in the memory of these where the source can be read so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/vector.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Values of any type as integers; what is no number is 0, which stands for no label. Throws
// Error(kBadInput) for a value above all of Int64.
Vector<std::int64_t> to_integers(const ArrayInfo& info, std::span<const std::byte> values);

// What a format has for labels of cells.
struct LabelPlace {
  const char* own = "";              // the array that is made of them when such a file is read
  std::string_view name;             // "references"
  int bits = 64;                     // of a value
  bool holds_own_fractions = false;  // of `own`
  bool is_only_place = true;         // for arrays of cells
};

// Of the cell arrays those that may be these labels, the first one before all others: the integers
// called `own`, or as another format calls its own, then the one called `label`, of any type, then
// the first of integers that is named like a region, and of floating-point numbers. With
// `label_comes_first` that one is before all.
std::vector<std::size_t> possible_labels(const AttributeSet& cells, const LabelPlace& place,
                                         const std::string& label, bool label_comes_first);

// Rows that one thread makes text of at a time.
inline constexpr std::size_t kTextRowsPerBlock = 16384;

class MeshPasses {
 public:
  static constexpr std::size_t kNone = AttributeSet::npos;

  // Counts the cells, and keeps those of lower dimension. Both must outlive this object.
  MeshPasses(MeshSource* source, const MeshStream* stream);

  const MeshDescription& description() const { return source_->description(); }
  // Of these arrays of cells the first one whose values the format has room for, and are not 0
  // everywhere, if another one is not: it has no more to say than none. tell() is called, if it is
  // there, where that is another one than names say; `label` is the name that the user gave. Where
  // just that one is meant and has no room, throws Error(kUsage).
  void choose_labels(const std::vector<std::size_t>& possible, const LabelPlace& place,
                     const std::string& label, bool is_meant, const std::string& path,
                     const std::function<void(std::string_view)>& tell);
  std::size_t cell_labels() const { return labels_; }  // kNone: there are none
  std::uint64_t points() const { return stream_->points(); }
  std::uint64_t tets() const { return tets_; }
  const LowerCells& lower() const { return lower_; }
  // The numbers of the cells of lower dimension of that type, in order.
  Vector<std::uint64_t> lower_of_type(std::uint8_t type) const;

  // From now on progress(share) is called as rows are visited, `rows` of them in all.
  void expect(std::uint64_t rows, std::function<void(double)> progress);

  // Calls f(first, points, rows) for windows of points; rows[i] are the tuples of the point array
  // at arrays[i] (kNone: none).
  template <class F>
  void for_each_points(const std::vector<std::size_t>& arrays, F f) {
    std::vector<Vector<std::byte>> rows(arrays.size());
    for (std::uint64_t first = 0; first < points(); first += kWindow) {
      const std::uint64_t count = window(first, points());
      const Points window_points = read_points(first, count);
      for (std::size_t i = 0; i < arrays.size(); ++i) {
        rows[i] = read_rows(Association::kPoint, arrays[i], first, count);
      }
      f(first, window_points, rows);
      visited(count);
    }
  }
  // The same without the points, of one array: f(first, rows).
  template <class F>
  void for_each_point_rows(std::size_t array, F f) {
    for (std::uint64_t first = 0; first < points(); first += kWindow) {
      const std::uint64_t count = window(first, points());
      f(first, read_rows(Association::kPoint, array, first, count));
      visited(count);
    }
  }
  // Calls f(first, tets, rows), for the tetrahedra in order; rows[i] are those of the cell array at
  // arrays[i].
  template <class F>
  void for_each_tets(const std::vector<std::size_t>& arrays, F f) {
    CellWindow cells;
    std::vector<Vector<std::byte>> rows(arrays.size());
    std::uint64_t tet = 0;
    for (std::uint64_t first = 0; first < stream_->cells(); first += kWindow) {
      const std::uint64_t count = window(first, stream_->cells());
      stream_->read_cells(first, count, &cells);
      for (std::size_t i = 0; i < arrays.size(); ++i) {
        rows[i] = rows_of(cells.tet_rows, cells.tets.size(), arrays[i], first, count);
      }
      f(tet, cells.tets, rows);
      tet += cells.tets.size();
      visited(cells.tets.size());
    }
  }
  // Those of all cells of lower dimension.
  Vector<std::byte> lower_rows(std::size_t array) const;
  DataArray read_field(std::size_t index) const {
    return source_->read_array(Association::kField, index);
  }

 private:
  static constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;
  static std::uint64_t window(std::uint64_t first, std::uint64_t all) {
    return all - first < kWindow ? all - first : kWindow;
  }
  const ArrayInfo& info(Association association, std::size_t array) const;
  std::string refusal(std::size_t cell_array, int bits) const;
  bool is_zero(std::size_t cell_array) const;
  Points read_points(std::uint64_t first, std::uint64_t count) const;
  Vector<std::byte> read_rows(Association association, std::size_t array, std::uint64_t first,
                              std::uint64_t count) const;
  Vector<std::byte> rows_of(const Vector<std::uint64_t>& rows, std::size_t cells, std::size_t array,
                            std::uint64_t first, std::uint64_t count) const;
  void visited(std::uint64_t rows);

  MeshSource* source_;
  const MeshStream* stream_;
  std::size_t labels_ = kNone;
  std::uint64_t tets_ = 0;
  LowerCells lower_;
  std::vector<std::pair<std::uint64_t, Vector<std::uint64_t>>> lower_rows_;  // by windows
  std::function<void(double)> progress_;
  std::uint64_t expected_ = 0;
  std::uint64_t visited_ = 0;
};

// The integer array that says what points are: the one called `own`, else that of another format.
// kNone where there is none.
std::size_t find_point_labels(const AttributeSet& points, const char* own);

}  // namespace tetfusion
