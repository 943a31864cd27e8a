#include "driver/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "base/tasks.h"
#include "io/cell_order.h"
#include "io/output_file.h"
#include "io/vtu_writer.h"
#include "mesh/interface_inspection.h"

namespace tetfusion {

namespace {

// A point that a cell of lower dimension uses, and its number in the file.
struct Numbered {
  VertexId id;
  std::uint32_t number;
};

// The sections of the file that come from chunks, in the order in which the columns follow.
enum Section : std::uint32_t { kPositions, kCorners, kFirstColumn };

template <class Real>
class Exporter {
 public:
  Exporter(const MacroLod<Real>& mesh, const WorkMesh<Real>& layout, const LowerPart<Real>& lower,
           const CarriedArrays& carried, MeshSource* source, const ExportSettings& settings,
           const RunContext& context, MemoryBudget* budget, Scratch* scratch)
      : mesh_(mesh),
        layout_(layout),
        lower_(lower),
        carried_(carried),
        source_(source),
        settings_(settings),
        context_(context),
        budget_(budget),
        scratch_(scratch) {}

  MeshSummary run() {
    number();
    OutputFile file(settings_.path, VtuWriter::access(settings_.encoding));
    VtuWriter writer(&file, layout_of_file(), [this](double done) {
      if (chunks_share_ < 1) report(chunks_share_ + (1 - chunks_share_) * done);
    });
    if (writer.can_leave_room()) {
      write_in_place(&writer, &file);
    } else {
      write_in_order(&writer);
    }
    context_.check();
    writer.finish();
    file.commit();
    return summary_;
  }

 private:
  struct Worker {
    explicit Worker(const WorkMesh<Real>& layout) : mesh(layout) {}
    ChunkGather<Real> gather;
    WorkMesh<Real> mesh;
    ChunkInspector inspector;
    Vector<std::uint32_t> own;      // vertices that the chunk writes, in the order of their numbers
    Vector<std::uint32_t> numbers;  // in the file, of each vertex
  };
  // Where in the file the values of the chunks' sections begin.
  struct Places {
    std::vector<std::uint64_t> sections;
    std::uint64_t offsets = 0;
    std::uint64_t types = 0;
  };

  void report(double done) const {
    if (settings_.progress) settings_.progress(done);
  }
  void number();
  std::uint32_t number_on_interface(VertexId id, std::uint32_t* low) const;
  std::int64_t number_of_lower(VertexId id) const;
  void name_vertices(std::uint32_t chunk, Worker* worker);
  template <class Emit>
  void for_each_chunk(Emit emit);
  void settle_lower();
  VtuLayout layout_of_file() const;

  void write_in_place(VtuWriter* writer, const OutputFile* file);
  void place_chunk(std::uint32_t chunk, const Worker& worker, const Places& places,
                   const OutputFile& file) const;
  void place_lower(const Places& places, const OutputFile& file) const;

  void write_in_order(VtuWriter* writer);
  void store_chunk(std::uint32_t chunk, const Worker& worker);
  template <class F>
  void for_each_piece(std::uint32_t section, F put);

  Vector<Vec3<Real>> own_positions(const Worker& worker) const;
  Vector<std::byte> own_rows(const Column& column, const Worker& worker) const;
  Vector<std::int64_t> lower_corners() const;
  CellOrder cells() const { return {summary_.tets, &lower_.cells}; }

  const MacroLod<Real>& mesh_;
  const WorkMesh<Real>& layout_;
  const LowerPart<Real>& lower_;
  const CarriedArrays& carried_;
  MeshSource* source_;
  const ExportSettings& settings_;
  const RunContext& context_;
  MemoryBudget* budget_;
  Scratch* scratch_;

  Vector<std::uint64_t> first_point_, first_tet_;  // of each chunk; one entry more
  Vector<std::uint32_t> rank_;     // of each interface table entry, among those of its lowest chunk
  Vector<std::uint32_t> between_;  // of each chunk: how many such entries it has
  std::vector<Vector<Numbered>> asked_for_;  // of each chunk: what cells of lower dimension use
  Vector<Numbered> numbered_;                // all of them, ascending by id
  std::unique_ptr<PieceStore> compacted_;
  MeshSummary summary_;
  double chunks_share_ = 1;  // of the work: going through the chunks
};

std::span<const std::byte> bytes_of(const auto& values) { return std::as_bytes(std::span(values)); }

// A chunk's own points are those that no lower chunk has: first those between chunks, by their ids,
// then the free ones, as they come. So every number is known before any chunk is read.
template <class Real>
void Exporter<Real>::number() {
  const Vector<InterfaceReport>& entries = mesh_.interface.entries();
  Vector<std::uint64_t> points, tets;
  points.assign(mesh_.chunks, 0);
  tets.assign(mesh_.chunks, 0);
  between_.assign(mesh_.chunks, 0);
  if (mesh_.whole) {
    points[0] = mesh_.whole->vertex_count();
    tets[0] = mesh_.whole->tets.size();
  } else {
    rank_.resize(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      ++points[entries[i].low];
      if (entries[i].low != entries[i].high) rank_[i] = between_[entries[i].low]++;
    }
    for (std::uint32_t c = 0; c < mesh_.chunks; ++c) {
      points[c] += mesh_.sizes[c].free_points;
      tets[c] = mesh_.sizes[c].tets;
    }
  }
  first_point_.push_back(0);
  first_tet_.push_back(0);
  for (std::uint32_t c = 0; c < mesh_.chunks; ++c) {
    first_point_.push_back(first_point_.back() + points[c]);
    first_tet_.push_back(first_tet_.back() + tets[c]);
  }
  summary_.path = settings_.path;
  summary_.points = first_point_.back() + lower_.loose_ids.size();
  summary_.tets = first_tet_.back();
  asked_for_.resize(mesh_.chunks);
}

template <class Real>
std::uint32_t Exporter<Real>::number_on_interface(VertexId id, std::uint32_t* low) const {
  const InterfaceReport* entry = mesh_.interface.find(id);
  if (entry == nullptr) throw std::logic_error("a vertex is missing in the interface table");
  *low = entry->low;
  const auto i = static_cast<std::size_t>(entry - mesh_.interface.entries().data());
  return static_cast<std::uint32_t>(first_point_[entry->low] + rank_[i]);
}

template <class Real>
void Exporter<Real>::name_vertices(std::uint32_t chunk, Worker* worker) {
  const WorkMesh<Real>& mesh = worker->mesh;
  const std::uint64_t first = first_point_[chunk];
  worker->own.resize(first_point_[chunk + 1] - first);
  worker->numbers.resize(mesh.vertex_count());
  std::size_t next_free = between_[chunk];
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const VertexId id = mesh.point_ids[v];
    std::uint32_t low = chunk;
    worker->numbers[v] = (mesh.marks[v] & kOnInterface) != 0
                             ? number_on_interface(id, &low)
                             : static_cast<std::uint32_t>(first + next_free++);
    if (low != chunk) continue;
    const std::size_t place = worker->numbers[v] - first;
    if (place >= worker->own.size()) throw std::logic_error("a chunk has more points than counted");
    worker->own[place] = static_cast<std::uint32_t>(v);
    if ((mesh.marks[v] & kLocked) != 0 &&
        std::binary_search(lower_.vertices.begin(), lower_.vertices.end(), id)) {
      asked_for_[chunk].push_back({id, worker->numbers[v]});
    }
  }
  if (next_free != worker->own.size())
    throw std::logic_error("a chunk has fewer points than counted");
}

// Gathers every chunk once, names its vertices, calls emit(chunk, worker), and judges it.
template <class Real>
template <class Emit>
void Exporter<Real>::for_each_chunk(Emit emit) {
  std::vector<std::unique_ptr<Worker>> workers;
  for (int i = 0; i < settings_.threads; ++i) workers.push_back(std::make_unique<Worker>(layout_));
  InterfaceInspection between;
  InOrder<ChunkFindings> join([&](ChunkFindings findings) { between.add(&findings); });
  std::atomic<std::size_t> done{0};
  run_tasks(mesh_.chunks, settings_.threads, [&](std::size_t c, std::size_t w) {
    context_.check();
    const auto chunk = static_cast<std::uint32_t>(c);
    Worker& worker = *workers[w];
    MemoryBudget::Reservation memory;
    if (mesh_.whole) {
      worker.mesh = *mesh_.whole;
    } else {
      memory = budget_->wait_for(chunk_memory(mesh_.pieces->bytes(chunk)), "a chunk to be written");
      const std::size_t ahead = c + workers.size();
      if (ahead < mesh_.chunks) mesh_.pieces->will_read(static_cast<std::uint32_t>(ahead));
      Rounds<Real>::gather(mesh_, chunk, &worker.gather, &worker.mesh);
    }
    name_vertices(chunk, &worker);
    emit(chunk, worker);
    Vector<std::uint8_t> sharing(worker.mesh.vertex_count());
    for (std::size_t v = 0; v < sharing.size(); ++v) sharing[v] = sharing_of(worker.mesh.marks[v]);
    Points points = std::move(worker.mesh.positions);
    join.put(c, worker.inspector.inspect({&points, worker.mesh.point_ids, sharing, {}},
                                         &worker.mesh.tets));
    worker.mesh.positions = std::move(std::get<Vector<Vec3<Real>>>(points));
    report(chunks_share_ * static_cast<double>(++done) / static_cast<double>(mesh_.chunks));
  });
  const InterfaceVerdict verdict = between.finish();
  summary_.boundary_triangles = verdict.boundary_faces;
  summary_.volume = verdict.volume;
  settle_lower();
}

template <class Real>
void Exporter<Real>::settle_lower() {
  for (const Vector<Numbered>& of_chunk : asked_for_) {
    numbered_.insert(numbered_.end(), of_chunk.begin(), of_chunk.end());
  }
  for (std::size_t i = 0; i < lower_.loose_ids.size(); ++i) {
    numbered_.push_back({lower_.loose_ids[i], static_cast<std::uint32_t>(first_point_.back() + i)});
  }
  std::sort(numbered_.begin(), numbered_.end(),
            [](const Numbered& a, const Numbered& b) { return a.id < b.id; });
}

template <class Real>
std::int64_t Exporter<Real>::number_of_lower(VertexId id) const {
  const auto at =
      std::lower_bound(numbered_.begin(), numbered_.end(), id,
                       [](const Numbered& n, VertexId wanted) { return n.id < wanted; });
  if (at == numbered_.end() || at->id != id) {
    throw std::logic_error("a point of the result has no number");
  }
  return at->number;
}

template <class Real>
Vector<std::int64_t> Exporter<Real>::lower_corners() const {
  Vector<std::int64_t> corners;
  for (const VertexId v : lower_.cells.connectivity) corners.push_back(number_of_lower(v));
  return corners;
}

template <class Real>
VtuLayout Exporter<Real>::layout_of_file() const {
  VtuLayout file;
  file.points = summary_.points;
  file.cells = cells().size();
  file.corners = 4 * summary_.tets + lower_.cells.connectivity.size();
  file.point_type = value_type_of<Real>();
  file.point_data = carried_.point_data;
  file.cell_data = carried_.cell_data;
  const AttributeSet& fields = source_->description().field_data;
  for (std::size_t i = 0; i < fields.arrays.size(); ++i) {
    file.field_data.push_back(source_->read_array(Association::kField, i));
  }
  file.encoding = settings_.encoding;
  return file;
}

template <class Real>
Vector<Vec3<Real>> Exporter<Real>::own_positions(const Worker& worker) const {
  Vector<Vec3<Real>> positions(worker.own.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = worker.mesh.positions[worker.own[i]];
  }
  return positions;
}

template <class Real>
Vector<std::byte> Exporter<Real>::own_rows(const Column& column, const Worker& worker) const {
  const std::size_t stride = column.stride();
  Vector<std::byte> rows(worker.own.size() * stride);
  for (std::size_t i = 0; i < worker.own.size(); ++i) {
    std::memcpy(rows.data() + i * stride, column.rows.data() + worker.own[i] * stride, stride);
  }
  return rows;
}

// Raw values have places that are known from the start: chunks write themselves there, side by
// side.
template <class Real>
void Exporter<Real>::write_in_place(VtuWriter* writer, const OutputFile* file) {
  Places places;
  places.sections.resize(kFirstColumn + layout_.point_columns.size() + layout_.cell_columns.size());
  // An array without values has no room, and nothing is placed in it.
  const auto leave_room = [&](std::uint64_t values) {
    return values > 0 ? writer->leave_room() : 0;
  };
  const std::uint64_t rows = cells().size();
  std::size_t section = kFirstColumn;
  for (std::size_t c = 0; c < layout_.point_columns.size(); ++c) {
    places.sections[section++] = leave_room(summary_.points * layout_.point_columns[c].components);
  }
  for (std::size_t c = 0; c < layout_.cell_columns.size(); ++c) {
    places.sections[section++] = leave_room(rows * layout_.cell_columns[c].components);
  }
  places.sections[kPositions] = leave_room(summary_.points);
  places.sections[kCorners] = leave_room(rows);
  places.offsets = leave_room(rows);
  places.types = leave_room(rows);
  for_each_chunk([&](std::uint32_t chunk, const Worker& worker) {
    place_chunk(chunk, worker, places, *file);
  });
  place_lower(places, *file);
}

template <class Real>
void Exporter<Real>::place_chunk(std::uint32_t chunk, const Worker& worker, const Places& places,
                                 const OutputFile& file) const {
  const std::uint64_t point = first_point_[chunk];
  const std::uint64_t cell = first_tet_[chunk];
  const auto place = [&](std::uint64_t section, std::uint64_t before,
                         std::span<const std::byte> bytes) {
    file.place(section + before, bytes.data(), bytes.size());
  };
  const WorkMesh<Real>& mesh = worker.mesh;
  place(places.sections[kPositions], point * sizeof(Vec3<Real>), bytes_of(own_positions(worker)));
  std::size_t section = kFirstColumn;
  for (const Column& c : mesh.point_columns) {
    place(places.sections[section++], point * c.stride(), own_rows(c, worker));
  }
  for (const Column& c : mesh.cell_columns) {
    place(places.sections[section++], cell * c.stride(),
          {c.rows.data(), mesh.tets.size() * c.stride()});
  }
  Vector<std::array<std::int64_t, 4>> corners(mesh.tets.size());
  Vector<std::int64_t> ends(mesh.tets.size());
  Vector<std::uint8_t> types(mesh.tets.size());
  const CellOrder all = cells();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < 4; ++k) corners[t][k] = worker.numbers[mesh.tets[t][k]];
    ends[t] = all.end(cell + t);
    types[t] = all.type(cell + t);
  }
  place(places.sections[kCorners], cell * sizeof(corners[0]), bytes_of(corners));
  place(places.offsets, cell * sizeof(ends[0]), bytes_of(ends));
  place(places.types, cell, bytes_of(types));
}

template <class Real>
void Exporter<Real>::place_lower(const Places& places, const OutputFile& file) const {
  const std::uint64_t point = first_point_.back();
  const std::uint64_t cell = first_tet_.back();
  const auto place = [&](std::uint64_t offset, std::span<const std::byte> bytes) {
    if (!bytes.empty()) file.place(offset, bytes.data(), bytes.size());
  };
  place(places.sections[kPositions] + point * sizeof(Vec3<Real>), bytes_of(lower_.loose_positions));
  std::size_t section = kFirstColumn;
  for (const Column& c : lower_.loose_columns) {
    place(places.sections[section++] + point * c.stride(), c.rows);
  }
  section = kFirstColumn + layout_.point_columns.size();
  for (const Column& c : lower_.columns) {
    place(places.sections[section++] + cell * c.stride(), c.rows);
  }
  Vector<std::int64_t> ends;
  for (std::uint64_t i = 0; i < lower_.cells.size(); ++i) ends.push_back(cells().end(cell + i));
  place(places.sections[kCorners] + 4 * cell * sizeof(std::int64_t), bytes_of(lower_corners()));
  place(places.offsets + cell * sizeof(std::int64_t), bytes_of(ends));
  place(places.types + cell,
        lower_.cells.size() > 0 ? bytes_of(lower_.cells.types) : std::span<const std::byte>());
}

// What is encoded, or goes to a stream, must be written in the order of the file: chunks are put
// away by sections, and each section is put together from them.
template <class Real>
void Exporter<Real>::write_in_order(VtuWriter* writer) {
  chunks_share_ = 0.4;
  compacted_ = scratch_->begin(fmt::format("output-{}", mesh_.tets));
  for_each_chunk([&](std::uint32_t chunk, const Worker& worker) { store_chunk(chunk, worker); });
  compacted_->seal();
  const auto put = [&](std::span<const std::byte> bytes) { writer->put(bytes); };
  std::uint32_t section = kFirstColumn;
  for (std::size_t c = 0; c < layout_.point_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (!lower_.loose_ids.empty()) writer->put(lower_.loose_columns[c].rows);
  }
  for (std::size_t c = 0; c < layout_.cell_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (lower_.cells.size() > 0) writer->put(lower_.columns[c].rows);
  }
  for_each_piece(kPositions, put);
  writer->put(bytes_of(lower_.loose_positions));
  Vector<std::int64_t> corners;
  for_each_piece(kCorners, [&](std::span<const std::byte> bytes) {
    const auto* numbers = reinterpret_cast<const std::uint32_t*>(bytes.data());
    corners.assign(numbers, numbers + bytes.size() / sizeof(std::uint32_t));
    writer->put(bytes_of(corners));
  });
  writer->put(bytes_of(lower_corners()));
  put_ends_and_types(cells(), writer);
  compacted_.reset();
}

// Each section is a piece of its own: bucket = section * chunks + chunk.
template <class Real>
void Exporter<Real>::store_chunk(std::uint32_t chunk, const Worker& worker) {
  const WorkMesh<Real>& mesh = worker.mesh;
  const auto bucket = [&](std::uint32_t section) { return section * mesh_.chunks + chunk; };
  const Vector<Vec3<Real>> positions = own_positions(worker);
  Vector<Tet> corners = mesh.tets;
  for (Tet& t : corners) {
    for (VertexId& v : t) v = worker.numbers[v];
  }
  std::vector<Vector<std::byte>> rows;
  for (const Column& c : mesh.point_columns) rows.push_back(own_rows(c, worker));
  std::vector<PieceRef> pieces{{bucket(kPositions), bytes_of(positions)},
                               {bucket(kCorners), bytes_of(corners)}};
  std::uint32_t section = kFirstColumn;
  for (const Vector<std::byte>& r : rows) pieces.push_back({bucket(section++), r});
  for (const Column& c : mesh.cell_columns) {
    pieces.push_back({bucket(section++), {c.rows.data(), mesh.tets.size() * c.stride()}});
  }
  std::erase_if(pieces, [](const PieceRef& p) { return p.bytes.empty(); });
  compacted_->add(chunk, pieces);
}

// Calls put(bytes) for a section of all chunks, in order, and drops it.
template <class Real>
template <class F>
void Exporter<Real>::for_each_piece(std::uint32_t section, F put) {
  for (std::uint32_t c = 0; c < mesh_.chunks; ++c) {
    context_.check();
    const std::uint32_t bucket = section * mesh_.chunks + c;
    if (compacted_->bytes(bucket) == 0) continue;
    put(compacted_->read(bucket)->pieces()[0]);
    compacted_->forget(bucket);
  }
}

}  // namespace

template <class Real>
MeshSummary export_mesh(const MacroLod<Real>& mesh, const WorkMesh<Real>& layout,
                        const LowerPart<Real>& lower, const CarriedArrays& carried,
                        MeshSource* source, const ExportSettings& settings,
                        const RunContext& context, MemoryBudget* budget, Scratch* scratch) {
  return Exporter<Real>(mesh, layout, lower, carried, source, settings, context, budget, scratch)
      .run();
}

template MeshSummary export_mesh(const MacroLod<float>&, const WorkMesh<float>&,
                                 const LowerPart<float>&, const CarriedArrays&, MeshSource*,
                                 const ExportSettings&, const RunContext&, MemoryBudget*, Scratch*);
template MeshSummary export_mesh(const MacroLod<double>&, const WorkMesh<double>&,
                                 const LowerPart<double>&, const CarriedArrays&, MeshSource*,
                                 const ExportSettings&, const RunContext&, MemoryBudget*, Scratch*);

}  // namespace tetfusion
