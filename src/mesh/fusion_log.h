// What fusions did to a mesh, so that they can be undone: each as a record of its own, in the order
// in which they happened. Points and tetrahedra go by their numbers in the input.
//
// A record is undone on the mesh that it left. Its *star* are the tetrahedra of the kept vertex
// there, ascending by number; its *ring* the other vertices of these, as they are met first, corner
// by corner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "base/serialize.h"
#include "base/vector.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// A corner of a tetrahedron that was deleted: 0 is the kept vertex, then the points that come back,
// then the ring; or kNoCode, and the vertex is one of `elsewhere`.
using CornerCode = std::uint16_t;
inline constexpr CornerCode kNoCode = std::numeric_limits<CornerCode>::max();

// At most so many vertices besides the kept one had tetrahedra of the star.
inline constexpr std::uint32_t kMaxGone = 3;

// What is known of the error that a fusion left: of a steering field, as a share of its range.
enum class FusionErrors : std::uint8_t {
  kNone,
  kMean,     // about the root of the mean square, as the run's quadrics had it
  kLargest,  // at no point of the original that the new tetrahedra hold is there a larger one
};

// One fusion. Rows are those of points, position first, then all columns; they are noted as what
// differs from the kept vertex's after the fusion, by exclusive or.
struct FusionRecord {
  VertexId kept = 0;
  // What is known of the error that it left (FusionErrors).
  float error = 0;
  std::uint32_t gone = 0;            // of the points, those that had tetrahedra of the star
  std::span<const VertexId> points;  // that come back
  std::span<const std::byte> rows;   // of these; before them the kept vertex's, where that changed
  std::span<const std::uint8_t>
      star;  // whose each tetrahedron was: 0 the kept vertex's, i points[i - 1]'s
  std::span<const TetId> tets;                         // that come back, ascending
  std::span<const std::array<CornerCode, 4>> corners;  // of these
  std::span<const VertexId> elsewhere;                 // in the order of the corners that name them
  std::span<const std::byte> tet_rows;                 // of these, all columns

  bool row_changed(std::size_t row_bytes) const { return rows.size() > points.size() * row_bytes; }
};

// The records of one chunk's work. Appended to by one thread.
class FusionLog {
 public:
  std::size_t size() const { return starts_.size(); }
  std::uint64_t tets() const { return tets_.size(); }
  std::uint64_t row_bytes() const { return rows_.size() + tet_rows_.size(); }
  FusionRecord operator[](std::size_t i) const;
  void append(const FusionRecord& record);
  // As bytes of this machine, and back.
  void save(ByteWriter* out) const;
  void load(ByteReader* in);

 private:
  struct Starts {
    VertexId kept;
    float error;
    std::uint32_t gone;
    std::uint64_t points, rows, star, tets, elsewhere, tet_rows;
  };
  Vector<Starts> starts_;
  Vector<VertexId> points_;
  Vector<std::byte> rows_;
  Vector<std::uint8_t> star_;
  Vector<TetId> tets_;
  Vector<std::array<CornerCode, 4>> corners_;
  Vector<VertexId> elsewhere_;
  Vector<std::byte> tet_rows_;
};

// Bytes of a point's row, and of a tetrahedron's, of which the last column, its number in the
// input, is no part.
template <class Real>
std::size_t point_row_bytes(const WorkMesh<Real>& layout);
template <class Real>
std::size_t tet_row_bytes(const WorkMesh<Real>& layout);
// Copies a row to `out`.
template <class Real>
void copy_point_row(const WorkMesh<Real>& mesh, std::size_t vertex, std::byte* out);
template <class Real>
void copy_tet_row(const WorkMesh<Real>& mesh, std::size_t tet, std::byte* out);
// The tetrahedra's numbers in the input: the last of the cell columns, where a log is kept.
template <class Real>
std::span<const TetId> original_numbers(const WorkMesh<Real>& mesh);

}  // namespace tetfusion
