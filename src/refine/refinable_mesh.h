// A mesh between its simplification and the original: fusions are undone on it one after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/files/paged_array.h"
#include "io/progressive/progressive_file.h"
#include "mesh/fusion_log.h"
#include "mesh/geometry.h"
#include "refine/stars.h"

namespace tetfusion {

// Points and cells go by their numbers in the original. Whatever it is given, it stays consistent:
// `fail`, which throws, is called with what is wrong; the mesh is of no use then.
class RefinableMesh {
 public:
  using Fail = std::function<void(const std::string& what)>;
  // In memory, or on the disk of `folder`: then what has been touched is in memory until let_go().
  RefinableMesh(const ProgressiveCounts& counts, std::size_t point_row_bytes,
                std::size_t cell_row_bytes, Fail fail, const std::string& folder = {});
  // Bytes of memory, or of the disk, that such a mesh takes in the end, about.
  static std::uint64_t bytes_for(const ProgressiveCounts& counts, std::size_t point_row_bytes,
                                 std::size_t cell_row_bytes);

  // First all points and cells of the simplified mesh, points first; then fusions, in the order of
  // the file. Points that no cell uses may come at any time. Of many, keep() is called each time
  // some have been added.
  void add_points(const PointRows& points, const std::function<void()>& keep = {});
  void add_tets(const TetRows& tets, const std::function<void()>& keep = {});
  void add_lower(const LowerRows& lower);
  void undo(const FusionRecord& record);
  // Hints what will be undone next, and what after that: who waits for memory waits for most of it.
  void expect(std::span<const VertexId> kept, std::span<const TetId> tets) const;
  // Takes out of this process what lies on the disk.
  void let_go() const;
  // Of the fusion that was undone last, ascending.
  std::span<const TetId> star() const { return star_; }
  // Winds these tetrahedra the other way.
  void rewind(std::span<const TetId> tets);

  std::uint64_t tets() const { return tets_; }
  std::uint64_t points() const { return points_; }
  std::uint64_t cells() const { return cells_; }
  // VTK's type of a cell; 0: there is none of that number (yet).
  std::uint8_t type_of(std::size_t cell) const { return types_[cell]; }
  std::span<const VertexId> corners_of(std::size_t cell) const;
  bool has_point(std::size_t point) const {
    return stars_.stamp(static_cast<VertexId>(point)) != 0;
  }
  const std::byte* point_row(std::size_t point) const {
    return point_rows_.data() + point * point_row_;
  }
  const std::byte* cell_row(std::size_t cell) const { return cell_rows_.data() + cell * cell_row_; }

 private:
  void require(bool holds, const char* what) const {
    if (!holds) fail_(what);
  }
  bool is_point(VertexId v) const { return v < stars_.size() && stars_.stamp(v) != 0; }
  void add_point(VertexId v, const std::byte* row);
  void add_tet(TetId number, const Tet& corners, const std::byte* row);
  void find_codes(const FusionRecord& record);
  void bring_points(const FusionRecord& record);
  void share_star(const FusionRecord& record);
  void bring_tets(const FusionRecord& record);

  std::size_t point_row_, cell_row_;
  Fail fail_;
  PagedArray<std::byte> point_rows_, cell_rows_;
  PagedArray<std::uint8_t> types_;
  PagedArray<Tet> corners_;  // of a cell of lower dimension: the first is its number in lower_
  LowerCells lower_;
  Stars
      stars_;  // stamps: 0, there is no such point (yet); that of the fusion in hand: it has a code
  std::uint64_t tets_ = 0, cells_ = 0, points_ = 0;

  // The fusion in hand.
  std::vector<TetId> star_;
  std::vector<std::vector<TetId>> shares_;  // of the star, by whose they were
  std::vector<VertexId> codes_;             // what each code of a corner stands for
  std::vector<std::byte> kept_row_, row_;
  std::uint32_t stamped_ = 1;
};

}  // namespace tetfusion
