#include "driver/export/export_memory.h"

#include <cstring>

#include "io/vtk/cell_order.h"

namespace tetfusion {

namespace {

template <class Real>
class MemoryExporter {
 public:
  explicit MemoryExporter(const ExportJob<Real>& job)
      : job_(job), chunks_(job), cells_{chunks_.summary().tets, &job.lower.cells} {}

  MeshSummary run() {
    room_ = job_.settings.sink->make_room(layout());
    chunks_.for_each(1, [this](const Chunk& chunk) { place_chunk(chunk); });
    place_lower();
    job_.check();
    if (room_.offsets != nullptr) put_number(room_.offsets, 0, 0);
    return chunks_.summary();
  }

 private:
  using Chunk = typename ExportChunks<Real>::Chunk;

  MeshLayout layout() const {
    MeshLayout out;
    out.points = chunks_.summary().points;
    out.tets = cells_.tets;
    out.cells = cells_.size();
    out.corners = 4 * cells_.tets + job_.lower.cells.connectivity.size();
    out.point_type = value_type_of<Real>();
    out.point_data = job_.carried.point_data;
    out.cell_data = job_.carried.cell_data;
    return out;
  }

  static void place(std::byte* array, std::uint64_t offset, std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(array + offset, bytes.data(), bytes.size());
  }

  void put_number(std::byte* array, std::uint64_t at, std::int64_t value) const {
    if (room_.id_type == ValueType::kInt32) {
      reinterpret_cast<std::int32_t*>(array)[at] = static_cast<std::int32_t>(value);
    } else {
      reinterpret_cast<std::int64_t*>(array)[at] = value;
    }
  }

  // Where cells from `first` on end, and their types.
  void describe_cells(std::uint64_t first, std::uint64_t count) const {
    if (room_.offsets == nullptr) return;
    for (std::uint64_t c = first; c < first + count; ++c) {
      put_number(room_.offsets, c + 1, cells_.end(c));
      room_.types[c] = cells_.type(c);
    }
  }

  void place_chunk(const Chunk& chunk) const {
    const WorkMesh<Real>& mesh = chunk.mesh;
    const std::uint64_t point = chunks_.first_point(chunk.number);
    const std::uint64_t cell = chunks_.first_tet(chunk.number);
    place(room_.points, point * sizeof(Vec3<Real>), bytes_of(positions_of(mesh, chunk.own)));
    for (std::size_t i = 0; i < mesh.point_columns.size(); ++i) {
      const Column& c = mesh.point_columns[i];
      place(room_.point_arrays[i], point * c.stride(), rows_of(c, chunk.own));
    }
    for (std::size_t i = 0; i < mesh.cell_columns.size(); ++i) {
      const Column& c = mesh.cell_columns[i];
      place(room_.cell_arrays[i], cell * c.stride(),
            {c.rows.data(), mesh.tets.size() * c.stride()});
    }
    std::uint64_t at = 4 * cell;
    for (const Tet& tet : mesh.tets) {
      for (const VertexId v : tet) put_number(room_.connectivity, at++, chunk.numbers[v]);
    }
    describe_cells(cell, mesh.tets.size());
  }

  void place_lower() const {
    const LowerPart<Real>& lower = job_.lower;
    const std::uint64_t point = chunks_.first_point(chunks_.chunks());
    const std::uint64_t cell = chunks_.first_tet(chunks_.chunks());
    place(room_.points, point * sizeof(Vec3<Real>), bytes_of(lower.loose_positions));
    for (std::size_t i = 0; i < lower.loose_columns.size(); ++i) {
      const Column& c = lower.loose_columns[i];
      place(room_.point_arrays[i], point * c.stride(), c.rows);
    }
    for (std::size_t i = 0; i < lower.columns.size(); ++i) {
      const Column& c = lower.columns[i];
      place(room_.cell_arrays[i], cell * c.stride(), c.rows);
    }
    std::uint64_t at = 4 * cell;
    for (const std::int64_t corner : chunks_.lower_corners()) {
      put_number(room_.connectivity, at++, corner);
    }
    describe_cells(cell, lower.cells.size());
  }

  const ExportJob<Real>& job_;
  ExportChunks<Real> chunks_;
  CellOrder cells_;
  MeshRoom room_;
};

}  // namespace

template <class Real>
MeshSummary export_to_memory(const ExportJob<Real>& job) {
  return MemoryExporter<Real>(job).run();
}

template MeshSummary export_to_memory(const ExportJob<float>&);
template MeshSummary export_to_memory(const ExportJob<double>&);

}  // namespace tetfusion
