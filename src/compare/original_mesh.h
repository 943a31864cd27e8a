// The original mesh, read in windows.
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/face_match.h"
#include "compare/fields.h"
#include "compare/parts.h"
#include "compare/point.h"
#include "compare/triangles.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Some of the points of a mesh, and their numbers in ascending order. A bit a point of the mesh,
// and half a bit for the numbers.
class PointSet {
 public:
  explicit PointSet(std::uint64_t points) : points_(points) { clear(); }

  void clear() { words_.assign(points_ / 64 + 1, 0); }
  void add(std::uint64_t id) { words_[id / 64] |= std::uint64_t{1} << id % 64; }
  void add(const Vector<Tet>& tets);  // their corners
  bool has(std::uint64_t id) const { return (words_[id / 64] >> id % 64 & 1) != 0; }

  // After the last add().
  void number();
  // How many of the set are smaller than id. id <= points.
  std::uint64_t number_of(std::uint64_t id) const {
    const std::uint64_t below = words_[id / 64] & ((std::uint64_t{1} << id % 64) - 1);
    return before_[id / 64] + ones_in(below);
  }
  std::uint64_t size() const { return number_of(points_); }
  // Which of the set has that number. number < size().
  std::uint64_t id_of(std::uint64_t number) const;
  std::uint64_t points() const { return points_; }

  // Whether it has one of the ids from 64 * word on, 64 of them.
  bool any_in_word(std::uint64_t word) const { return words_[word] != 0; }

 private:
  // std::popcount() is a call where not every processor has an instruction for it.
  static std::uint64_t ones_in(std::uint64_t bits) {
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    return ((bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0Fu) * 0x0101010101010101u >> 56;
  }

  std::uint64_t points_;
  Vector<std::uint64_t> words_;
  Vector<std::uint32_t> before_;  // in all words before
};

struct OriginalPoints {
  Vector<VertexId> ids;  // of the stream, ascending
  Vector<Point> points;
  Vector<double> rows;  // of the point fields
  // What part of the simplified mesh they became; empty where that is not known.
  Vector<std::uint32_t> parts;
  std::uint32_t part_of(std::size_t p) const { return parts.empty() ? kAnyPart : parts[p]; }
};

struct OriginalCells {
  std::uint64_t first_row = 0;
  Vector<std::uint64_t> tet_rows;  // as in CellWindow
  std::uint64_t row(std::size_t t) const { return tet_rows.empty() ? first_row + t : tet_rows[t]; }
  Vector<Tet> tets;  // ids of `points`; wound as in the file
  OriginalPoints points;
  Vector<double> cell_rows;  // of the cell fields
};

class OriginalMesh {
 public:
  // Opens a stream over the source, which must outlive this.
  OriginalMesh(MeshSource* source, const FieldSet& point_fields, const FieldSet& cell_fields);

  // Sets the bases of those of the fields that have integers of 64 bits: what the first tetrahedron
  // has, or its first corner.
  void choose_bases(Association association, FieldSet* fields) const;

  // Finds the boundary and what the mesh consists of: call it first. About `most_sides` sides of
  // triangles are in memory at once.
  void survey(std::size_t most_sides, const RunContext& context);
  // Looks for each part in those of the simplified mesh: windows, and the boundary, say then which
  // they are of. Call it after survey(), if at all.
  void match_parts(std::span<const PartFigures> simplified, const RunContext& context);
  std::uint64_t points() const { return used_.size(); }  // that a tetrahedron uses
  std::uint64_t all_points() const { return stream_->points(); }
  const MeshStream& stream() const { return *stream_; }
  std::uint64_t tets() const { return tets_; }
  const TriangleSet& boundary() const { return boundary_; }  // ordered
  TriangleSet take_boundary() { return std::move(boundary_); }

  // The triangles between cells whose values of some of these cell arrays, integers of one
  // component, differ; ordered. About `most_sides` sides are in memory at once.
  TriangleSet find_interfaces(const std::vector<std::size_t>& cell_arrays, std::size_t most_sides,
                              const RunContext& context) const;

  // All points that a tetrahedron uses, and all tetrahedra, window by window, in order. `share` is
  // how much has been read, 0 to 1.
  void for_each_points(const std::function<void(const OriginalPoints&, double share)>& take) const;
  void for_each_cells(const std::function<void(const OriginalCells&, double share)>& take) const;

 private:
  std::optional<std::uint64_t> first_row_in_use(Association association) const;
  void read_cells(const std::function<void(std::uint64_t, const CellWindow&, double)>& take) const;
  TriangleSet triangles_of(const Vector<CellSide>& sides) const;
  void gather_corners(const CellWindow& window, const FieldSet& fields, PointSet* set,
                      OriginalCells* out) const;
  void gather(const PointSet& set, std::uint64_t first, std::uint64_t count, const FieldSet& fields,
              OriginalPoints* out) const;
  void gather_run(const PointSet& set, std::uint64_t first, std::uint64_t count,
                  const FieldSet& fields, OriginalPoints* out, std::uint64_t base) const;
  void gather_cell_rows(std::uint64_t first, std::uint64_t count, const CellWindow& window,
                        Vector<double>* out) const;

  MeshSource* source_;
  const FieldSet& point_fields_;
  const FieldSet& cell_fields_;
  const std::uint64_t window_;  // rows that are in memory at once
  std::unique_ptr<MeshStream> stream_;
  PointSet used_;
  std::uint64_t tets_ = 0;
  TriangleSet boundary_;
  Vector<std::uint32_t> part_of_;  // of all points: the part of the simplified mesh, if known
};

}  // namespace tetfusion
