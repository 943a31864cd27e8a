// What every way of writing a macroLoD needs: its chunks one after another, and the number that
// each point has in the result.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "driver/export/export.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

// A chunk's own points are those that no lower chunk has: first those between chunks, by their ids,
// then the free ones, as they come. So every number is known before any chunk is read. Points that
// only cells of lower dimension use come last.
template <class Real>
class ExportChunks {
 public:
  // A chunk in hand.
  struct Chunk {
    explicit Chunk(const WorkMesh<Real>& layout) : mesh(layout) {}
    std::uint32_t number = 0;
    WorkMesh<Real> mesh;
    Vector<std::uint32_t> numbers;  // in the result, of each vertex
    Vector<std::uint32_t> own;      // its own vertices, in the order of their numbers
    ChunkGather<Real> gather;
    FitTools<Real> fit;
  };
  using Emit = std::function<void(const Chunk& chunk)>;
  // A point that a cell of lower dimension uses.
  struct Numbered {
    VertexId id;
    std::uint32_t number;
  };

  explicit ExportChunks(const ExportJob<Real>& job);

  std::uint32_t chunks() const { return job_.mesh.chunks; }
  // One entry more than there are chunks: the end.
  std::uint64_t first_point(std::uint32_t chunk) const { return first_point_[chunk]; }
  std::uint64_t first_tet(std::uint32_t chunk) const { return first_tet_[chunk]; }

  // Gathers every chunk once, side by side, calls emit() with it, and judges it. That is `share` of
  // the progress. With settings.original_ids these are the last of its point columns, as they are
  // of the job's layout.
  void for_each(double share, const Emit& emit);

  // But for the counts of points and tetrahedra, after for_each() alone.
  const MeshSummary& summary() const { return summary_; }

  // Of a chunk that for_each() has given, ascending by vertex: its own points that cells of lower
  // dimension use.
  const Vector<Numbered>& used_by_lower(std::uint32_t chunk) const { return asked_for_[chunk]; }
  // The corners of the cells of lower dimension.
  Vector<std::int64_t> lower_corners() const;

 private:
  void number();
  std::uint32_t number_on_interface(VertexId id, std::uint32_t* low) const;
  void name_vertices(Chunk* chunk);
  void note_original_ids(const Chunk& chunk) const;
  void take_numbers(Chunk* chunk) const;
  // `next` is the chunk that will be wanted after those in hand.
  MemoryBudget::Reservation take_mesh(std::size_t next, Chunk* chunk);
  void settle_lower();

  const ExportJob<Real>& job_;
  Vector<std::uint64_t> first_point_, first_tet_;
  Vector<std::uint32_t> rank_;     // of each interface table entry, among those of its lowest chunk
  Vector<std::uint32_t> between_;  // of each chunk: how many such entries it has
  std::vector<Vector<Numbered>> asked_for_;
  Vector<Numbered> numbered_;  // all of them, ascending by id
  MeshSummary summary_;
};

// The input's arrays, field data and type of points, for a file with so many points and cells.
template <class Real>
VtuLayout layout_of_output(const ExportJob<Real>& job, std::uint64_t points, std::uint64_t cells,
                           std::uint64_t corners);

// The input's numbers of points that stayed, -1 of those that are new: as a column, and of the
// vertices of a mesh.
Column column_of(const Vector<std::int64_t>& original_ids);
template <class Real>
Vector<std::int64_t> original_ids_of(const WorkMesh<Real>& mesh);

// Those of some vertices, in that order.
template <class Real>
Vector<Vec3<Real>> positions_of(const WorkMesh<Real>& mesh,
                                std::span<const std::uint32_t> vertices);
Vector<std::byte> rows_of(const Column& column, std::span<const std::uint32_t> vertices);

inline std::span<const std::byte> bytes_of(const auto& values) {
  return std::as_bytes(std::span(values));
}

extern template class ExportChunks<float>;
extern template class ExportChunks<double>;

}  // namespace tetfusion
