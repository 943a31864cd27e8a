#include "driver/export/export_chunks.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

#include "base/tasks.h"
#include "mesh/inspection/interface_inspection.h"

namespace tetfusion {

template <class Real>
ExportChunks<Real>::ExportChunks(const ExportJob<Real>& job) : job_(job) {
  number();
}

template <class Real>
void ExportChunks<Real>::number() {
  const MacroLod<Real>& mesh = job_.mesh;
  const Vector<InterfaceReport>& entries = mesh.interface.entries();
  Vector<std::uint64_t> points, tets;
  points.assign(mesh.chunks, 0);
  tets.assign(mesh.chunks, 0);
  between_.assign(mesh.chunks, 0);
  if (mesh.whole) {
    points[0] = mesh.whole->vertex_count();
    tets[0] = mesh.whole->tets.size();
  } else {
    rank_.resize(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      ++points[entries[i].low];
      if (entries[i].low != entries[i].high) rank_[i] = between_[entries[i].low]++;
    }
    for (std::uint32_t c = 0; c < mesh.chunks; ++c) {
      points[c] += mesh.sizes[c].free_points;
      tets[c] = mesh.sizes[c].tets;
    }
  }
  first_point_.push_back(0);
  first_tet_.push_back(0);
  for (std::uint32_t c = 0; c < mesh.chunks; ++c) {
    first_point_.push_back(first_point_.back() + points[c]);
    first_tet_.push_back(first_tet_.back() + tets[c]);
  }
  summary_.path = job_.settings.path;
  summary_.points = first_point_.back() + job_.lower.loose_ids.size();
  summary_.tets = first_tet_.back();
  asked_for_.resize(mesh.chunks);
}

template <class Real>
std::uint32_t ExportChunks<Real>::number_on_interface(VertexId id, std::uint32_t* low) const {
  const InterfaceReport* entry = job_.mesh.interface.find(id);
  if (entry == nullptr) throw std::logic_error("a vertex is missing in the interface table");
  *low = entry->low;
  const auto i = static_cast<std::size_t>(entry - job_.mesh.interface.entries().data());
  return static_cast<std::uint32_t>(first_point_[entry->low] + rank_[i]);
}

template <class Real>
void ExportChunks<Real>::name_vertices(Chunk* chunk) {
  const WorkMesh<Real>& mesh = chunk->mesh;
  const std::uint32_t c = chunk->number;
  const Vector<VertexId>& carried = job_.lower.vertices;
  const std::uint64_t first = first_point_[c];
  chunk->own.resize(first_point_[c + 1] - first);
  chunk->numbers.resize(mesh.vertex_count());
  std::size_t next_free = between_[c];
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const VertexId id = mesh.point_ids[v];
    std::uint32_t low = c;
    chunk->numbers[v] = (mesh.marks[v] & kOnInterface) != 0
                            ? number_on_interface(id, &low)
                            : static_cast<std::uint32_t>(first + next_free++);
    if (low != c) continue;
    const std::size_t place = chunk->numbers[v] - first;
    if (place >= chunk->own.size()) throw std::logic_error("a chunk has more points than counted");
    chunk->own[place] = static_cast<std::uint32_t>(v);
    if ((mesh.marks[v] & kLocked) != 0 && std::binary_search(carried.begin(), carried.end(), id)) {
      asked_for_[c].push_back({id, chunk->numbers[v]});
    }
  }
  if (next_free != chunk->own.size())
    throw std::logic_error("a chunk has fewer points than counted");
}

template <class Real>
void ExportChunks<Real>::note_original_ids(const Chunk& chunk) const {
  if (job_.settings.point_ids == nullptr) return;
  const Vector<std::int64_t> ids = original_ids_of(chunk.mesh);
  const std::uint64_t first = first_point_[chunk.number];
  for (std::size_t i = 0; i < chunk.own.size(); ++i) {
    (*job_.settings.point_ids)[first + i] = ids[chunk.own[i]];
  }
}

// They are the last column, which is taken away.
template <class Real>
void ExportChunks<Real>::take_numbers(Chunk* chunk) const {
  if (job_.settings.cell_numbers != nullptr) {
    const Column& numbers = chunk->mesh.cell_columns.back();
    const auto* from = reinterpret_cast<const TetId*>(numbers.rows.data());
    const auto first = static_cast<std::ptrdiff_t>(first_tet_[chunk->number]);
    std::copy_n(from, chunk->mesh.tets.size(), job_.settings.cell_numbers->begin() + first);
  }
  chunk->mesh.cell_columns.pop_back();
}

// For as long as the reservation is held.
template <class Real>
MemoryBudget::Reservation ExportChunks<Real>::take_mesh(std::size_t next, Chunk* chunk) {
  const MacroLod<Real>& mesh = job_.mesh;
  if (mesh.whole) {
    chunk->mesh = *mesh.whole;
    return {};
  }
  const std::uint64_t fit = job_.fitted != nullptr ? job_.fitted->memory(chunk->number) : 0;
  auto memory = job_.budget->wait_for(chunk_memory(mesh.pieces->bytes(chunk->number)) + fit,
                                      "a chunk to be written");
  if (next < mesh.chunks) mesh.pieces->will_read(static_cast<std::uint32_t>(next));
  Rounds<Real>::gather(mesh, chunk->number, &chunk->gather, &chunk->mesh);
  return memory;
}

template <class Real>
void ExportChunks<Real>::for_each(double share, const Emit& emit) {
  const MacroLod<Real>& mesh = job_.mesh;
  if (job_.settings.point_ids != nullptr) job_.settings.point_ids->resize(summary_.points);
  if (job_.settings.cell_numbers != nullptr) {
    job_.settings.cell_numbers->resize(summary_.tets);
  }
  std::vector<std::unique_ptr<Chunk>> workers;
  for (int i = 0; i < job_.settings.threads; ++i) {
    workers.push_back(std::make_unique<Chunk>(job_.layout));
    if (job_.settings.original_ids) workers.back()->mesh.point_columns.pop_back();
    if (job_.settings.has_numbers) workers.back()->mesh.cell_columns.push_back(number_column());
  }
  InterfaceInspection between;
  InOrder<ChunkFindings> join([&](ChunkFindings findings) { between.add(&findings); });
  std::atomic<std::size_t> done{0};
  run_tasks(mesh.chunks, job_.settings.threads, [&](std::size_t c, std::size_t w) {
    job_.context.check();
    Chunk& chunk = *workers[w];
    chunk.number = static_cast<std::uint32_t>(c);
    const auto memory = take_mesh(c + workers.size(), &chunk);
    if (job_.settings.has_numbers) take_numbers(&chunk);
    if (job_.fitted != nullptr) job_.fitted->fit(chunk.number, &chunk.fit, &chunk.mesh);
    name_vertices(&chunk);
    note_original_ids(chunk);
    if (job_.settings.original_ids) {
      chunk.mesh.point_columns.push_back(column_of(original_ids_of(chunk.mesh)));
      emit(chunk);
      chunk.mesh.point_columns.pop_back();
    } else {
      emit(chunk);
    }
    join.put(c, inspect_as_marked(&chunk.mesh, false));
    if (job_.settings.has_numbers) chunk.mesh.cell_columns.push_back(number_column());
    job_.report(share * static_cast<double>(++done) / static_cast<double>(mesh.chunks));
  });
  const InterfaceVerdict verdict = between.finish();
  summary_.boundary_triangles = verdict.boundary_faces;
  summary_.volume = verdict.volume;
  settle_lower();
}

template <class Real>
void ExportChunks<Real>::settle_lower() {
  for (const Vector<Numbered>& of_chunk : asked_for_) {
    numbered_.insert(numbered_.end(), of_chunk.begin(), of_chunk.end());
  }
  const Vector<VertexId>& loose = job_.lower.loose_ids;
  for (std::size_t i = 0; i < loose.size(); ++i) {
    numbered_.push_back({loose[i], static_cast<std::uint32_t>(first_point_.back() + i)});
  }
  if (job_.settings.point_ids != nullptr) {
    std::copy(loose.begin(), loose.end(),
              job_.settings.point_ids->end() - static_cast<std::ptrdiff_t>(loose.size()));
  }
  if (job_.settings.cell_numbers != nullptr) {
    const Vector<TetId>& lower = job_.lower.numbers;
    job_.settings.cell_numbers->insert(job_.settings.cell_numbers->end(), lower.begin(),
                                       lower.end());
  }
  std::sort(numbered_.begin(), numbered_.end(),
            [](const Numbered& a, const Numbered& b) { return a.id < b.id; });
}

template <class Real>
Vector<std::int64_t> ExportChunks<Real>::lower_corners() const {
  Vector<std::int64_t> corners;
  corners.reserve(job_.lower.cells.connectivity.size());
  for (const VertexId v : job_.lower.cells.connectivity) {
    const auto at =
        std::lower_bound(numbered_.begin(), numbered_.end(), v,
                         [](const Numbered& n, VertexId wanted) { return n.id < wanted; });
    if (at == numbered_.end() || at->id != v) {
      throw std::logic_error("a point of the result has no number");
    }
    corners.push_back(at->number);
  }
  return corners;
}

template <class Real>
VtuLayout layout_of_output(const ExportJob<Real>& job, std::uint64_t points, std::uint64_t cells,
                           std::uint64_t corners) {
  VtuLayout file;
  file.points = points;
  file.cells = cells;
  file.corners = corners;
  file.point_type = value_type_of<Real>();
  file.point_data = job.carried.point_data;
  file.cell_data = job.carried.cell_data;
  file.field_data = job.source->read_field_data();
  file.encoding = job.settings.encoding;
  return file;
}

Column column_of(const Vector<std::int64_t>& original_ids) {
  const std::span<const std::byte> bytes = bytes_of(original_ids);
  return {ValueType::kInt64, 1, Vector<std::byte>(bytes.begin(), bytes.end())};
}

template <class Real>
Vector<std::int64_t> original_ids_of(const WorkMesh<Real>& mesh) {
  Vector<std::int64_t> ids(mesh.vertex_count());
  for (std::size_t v = 0; v < ids.size(); ++v) {
    ids[v] = (mesh.marks[v] & kMoved) != 0 ? -1 : std::int64_t{mesh.point_ids[v]};
  }
  return ids;
}

template <class Real>
Vector<Vec3<Real>> positions_of(const WorkMesh<Real>& mesh,
                                std::span<const std::uint32_t> vertices) {
  Vector<Vec3<Real>> positions(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) positions[i] = mesh.positions[vertices[i]];
  return positions;
}

Vector<std::byte> rows_of(const Column& column, std::span<const std::uint32_t> vertices) {
  const std::size_t stride = column.stride();
  Vector<std::byte> rows(vertices.size() * stride);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::memcpy(rows.data() + i * stride, column.rows.data() + vertices[i] * stride, stride);
  }
  return rows;
}

template class ExportChunks<float>;
template class ExportChunks<double>;
template Vector<std::int64_t> original_ids_of(const WorkMesh<float>&);
template Vector<std::int64_t> original_ids_of(const WorkMesh<double>&);
template Vector<Vec3<float>> positions_of(const WorkMesh<float>&, std::span<const std::uint32_t>);
template Vector<Vec3<double>> positions_of(const WorkMesh<double>&, std::span<const std::uint32_t>);
template VtuLayout layout_of_output(const ExportJob<float>&, std::uint64_t, std::uint64_t,
                                    std::uint64_t);
template VtuLayout layout_of_output(const ExportJob<double>&, std::uint64_t, std::uint64_t,
                                    std::uint64_t);

}  // namespace tetfusion
