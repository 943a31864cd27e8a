#include "driver/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "base/tasks.h"
#include "io/output_file.h"
#include "io/vtu_writer.h"
#include "mesh/interface_inspection.h"
#include "partition/radix_sort.h"

namespace tetfusion {

namespace {

constexpr std::uint8_t kVtkTetra = 10;

// A point that more than its own chunk needs to name, and its place among its chunk's own points.
struct Owned {
  VertexId id;
  std::uint32_t chunk;
  std::uint32_t place;
};

// The sections of a compacted chunk, each a piece of its own: bucket = section * chunks + chunk.
enum Section : std::uint32_t { kPositions, kCorners, kForeign, kFirstColumn };

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
    compact();
    number();
    write();
    return summary_;
  }

 private:
  struct Worker {
    explicit Worker(const WorkMesh<Real>& layout) : mesh(layout) {}
    ChunkGather<Real> gather;
    WorkMesh<Real> mesh;
    ChunkInspector inspector;
    Vector<std::uint32_t>
        names;  // of a vertex: its place among the own points, or the foreign ones
  };
  struct ChunkShare {
    ChunkFindings findings;
    Vector<Owned> owned;  // that others may ask for
    std::uint64_t points = 0;
    std::uint64_t tets = 0;
  };

  void compact();
  void compact_chunk(std::uint32_t chunk, WorkMesh<Real>& mesh, Worker* worker);
  bool is_asked_for(VertexId id, std::uint8_t marks) const;
  void number();
  std::uint64_t number_of(VertexId id) const;

  void write();
  VtuLayout layout_of_file() const;
  template <class F>
  void for_each_piece(std::uint32_t section, F put);
  void put_corners(VtuWriter* writer);
  void put_offsets_and_types(VtuWriter* writer) const;
  std::uint64_t points_of(std::uint32_t chunk) const {
    return first_point_[chunk + 1] - first_point_[chunk];
  }
  std::uint32_t bucket(std::uint32_t section, std::uint32_t chunk) const {
    return section * mesh_.chunks + chunk;
  }

  const MacroLod<Real>& mesh_;
  const WorkMesh<Real>& layout_;
  const LowerPart<Real>& lower_;
  const CarriedArrays& carried_;
  MeshSource* source_;
  const ExportSettings& settings_;
  const RunContext& context_;
  MemoryBudget* budget_;
  Scratch* scratch_;

  std::unique_ptr<PieceStore> compacted_;
  std::vector<ChunkShare> shares_;
  Vector<std::uint64_t> first_point_, first_tet_;  // of each chunk; one entry more
  Vector<Owned> owned_;                            // ascending by id
  MeshSummary summary_;
};

std::span<const std::byte> bytes_of(const auto& values) { return std::as_bytes(std::span(values)); }

template <class Real>
bool Exporter<Real>::is_asked_for(VertexId id, std::uint8_t marks) const {
  if ((marks & kOnInterface) != 0) return true;
  return (marks & kLocked) != 0 &&
         std::binary_search(lower_.vertices.begin(), lower_.vertices.end(), id);
}

// A chunk's own points are those that no lower chunk has. Corners name own points by their place,
// and others, from the number of own points on, by their place in a list of ids.
template <class Real>
void Exporter<Real>::compact_chunk(std::uint32_t chunk, WorkMesh<Real>& mesh, Worker* worker) {
  ChunkShare& share = shares_[chunk];
  Vector<std::uint32_t> own;
  Vector<VertexId> foreign;
  worker->names.resize(mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.marks[v] & kAway) != 0) continue;
    const auto place = static_cast<std::uint32_t>(own.size());
    worker->names[v] = place;
    own.push_back(static_cast<std::uint32_t>(v));
    const VertexId id = mesh.point_ids[v];
    if (is_asked_for(id, mesh.marks[v])) share.owned.push_back({id, chunk, place});
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.marks[v] & kAway) == 0) continue;
    worker->names[v] = static_cast<std::uint32_t>(own.size() + foreign.size());
    foreign.push_back(mesh.point_ids[v]);
  }
  share.points = own.size();
  share.tets = mesh.tets.size();

  Vector<Vec3<Real>> positions(own.size());
  for (std::size_t i = 0; i < own.size(); ++i) positions[i] = mesh.positions[own[i]];
  Vector<Tet> corners = mesh.tets;
  for (Tet& t : corners) {
    for (VertexId& v : t) v = worker->names[v];
  }
  std::vector<Vector<std::byte>> rows;
  for (const Column& c : mesh.point_columns) {
    const std::size_t stride = c.stride();
    Vector<std::byte>& to = rows.emplace_back(own.size() * stride);
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::memcpy(to.data() + i * stride, c.rows.data() + own[i] * stride, stride);
    }
  }
  std::vector<PieceRef> pieces{{bucket(kPositions, chunk), bytes_of(positions)},
                               {bucket(kCorners, chunk), bytes_of(corners)},
                               {bucket(kForeign, chunk), bytes_of(foreign)}};
  std::uint32_t section = kFirstColumn;
  for (const Vector<std::byte>& r : rows) pieces.push_back({bucket(section++, chunk), r});
  for (const Column& c : mesh.cell_columns) {
    pieces.push_back({bucket(section++, chunk), {c.rows.data(), mesh.tets.size() * c.stride()}});
  }
  std::erase_if(pieces, [](const PieceRef& p) { return p.bytes.empty(); });
  compacted_->add(chunk, pieces);

  Vector<std::uint8_t> on_interface(mesh.vertex_count());
  for (std::size_t v = 0; v < on_interface.size(); ++v) {
    on_interface[v] = sharing_of(mesh.marks[v]);
  }
  Points points = std::move(mesh.positions);
  share.findings =
      worker->inspector.inspect({&points, mesh.point_ids, on_interface, {}}, &mesh.tets);
  mesh.positions = std::move(std::get<Vector<Vec3<Real>>>(points));
}

template <class Real>
void Exporter<Real>::compact() {
  compacted_ = scratch_->begin(fmt::format("output-{}", mesh_.tets));
  shares_.resize(mesh_.chunks);
  std::vector<std::unique_ptr<Worker>> workers;
  for (int i = 0; i < settings_.threads; ++i) workers.push_back(std::make_unique<Worker>(layout_));
  run_tasks(mesh_.chunks, settings_.threads, [&](std::size_t c, std::size_t w) {
    context_.check();
    const auto chunk = static_cast<std::uint32_t>(c);
    Worker& worker = *workers[w];
    if (mesh_.whole) {
      worker.mesh = *mesh_.whole;
      compact_chunk(chunk, worker.mesh, &worker);
      return;
    }
    const auto memory =
        budget_->wait_for(chunk_memory(mesh_.pieces->bytes(chunk)), "a chunk to be written");
    Rounds<Real>::gather(mesh_, chunk, &worker.gather, &worker.mesh);
    compact_chunk(chunk, worker.mesh, &worker);
  });
  compacted_->seal();
}

template <class Real>
void Exporter<Real>::number() {
  first_point_.push_back(0);
  first_tet_.push_back(0);
  InterfaceInspection between;
  for (ChunkShare& share : shares_) {
    first_point_.push_back(first_point_.back() + share.points);
    first_tet_.push_back(first_tet_.back() + share.tets);
    owned_.insert(owned_.end(), share.owned.begin(), share.owned.end());
    between.add(&share.findings);
    share = {};
  }
  radix_sort<32>(&owned_, [](const Owned& o) { return o.id; });
  const InterfaceVerdict verdict = between.finish();
  summary_ = {settings_.path, first_point_.back() + lower_.loose_ids.size(), first_tet_.back(),
              verdict.boundary_faces, verdict.volume};
}

// The number of a point in the file, of those that are asked for.
template <class Real>
std::uint64_t Exporter<Real>::number_of(VertexId id) const {
  const auto owned =
      std::lower_bound(owned_.begin(), owned_.end(), id,
                       [](const Owned& o, VertexId wanted) { return o.id < wanted; });
  if (owned != owned_.end() && owned->id == id) return first_point_[owned->chunk] + owned->place;
  const auto loose = std::lower_bound(lower_.loose_ids.begin(), lower_.loose_ids.end(), id);
  if (loose == lower_.loose_ids.end() || *loose != id) {
    throw std::logic_error("a point of the result has no number");
  }
  return first_point_.back() + static_cast<std::uint64_t>(loose - lower_.loose_ids.begin());
}

template <class Real>
VtuLayout Exporter<Real>::layout_of_file() const {
  VtuLayout file;
  file.points = summary_.points;
  file.cells = summary_.tets + lower_.cells.size();
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

// Calls put(bytes) for a section of all chunks, in order, and drops it.
template <class Real>
template <class F>
void Exporter<Real>::for_each_piece(std::uint32_t section, F put) {
  for (std::uint32_t c = 0; c < mesh_.chunks; ++c) {
    context_.check();
    const std::uint32_t b = bucket(section, c);
    if (compacted_->bytes(b) == 0) continue;
    {
      const auto pieces = compacted_->read(b);
      put(pieces->pieces()[0]);
    }
    compacted_->forget(b);
  }
}

template <class Real>
void Exporter<Real>::put_corners(VtuWriter* writer) {
  const auto batch = static_cast<std::uint32_t>(4 * settings_.threads);
  std::vector<Vector<std::int64_t>> encoded(batch);
  for (std::uint32_t begin = 0; begin < mesh_.chunks; begin += batch) {
    context_.check();
    const std::uint32_t end = std::min(begin + batch, mesh_.chunks);
    run_tasks(end - begin, settings_.threads, [&](std::size_t i, std::size_t) {
      const auto c = begin + static_cast<std::uint32_t>(i);
      encoded[i].clear();
      if (compacted_->bytes(bucket(kCorners, c)) == 0) return;
      const auto pieces = compacted_->read(bucket(kCorners, c));
      const std::span<const std::byte> bytes = pieces->pieces()[0];
      Vector<std::uint64_t> foreign;
      if (compacted_->bytes(bucket(kForeign, c)) != 0) {
        const auto list = compacted_->read(bucket(kForeign, c));
        const std::span<const std::byte> ids = list->pieces()[0];
        const auto* begin_id = reinterpret_cast<const VertexId*>(ids.data());
        for (std::size_t k = 0; k < ids.size() / sizeof(VertexId); ++k) {
          foreign.push_back(number_of(begin_id[k]));
        }
      }
      const auto* names = reinterpret_cast<const VertexId*>(bytes.data());
      const std::uint64_t own = points_of(c);
      encoded[i].resize(bytes.size() / sizeof(VertexId));
      for (std::size_t k = 0; k < encoded[i].size(); ++k) {
        encoded[i][k] = static_cast<std::int64_t>(names[k] < own ? first_point_[c] + names[k]
                                                                 : foreign[names[k] - own]);
      }
    });
    for (std::uint32_t c = begin; c < end; ++c) {
      writer->put(bytes_of(encoded[c - begin]));
      compacted_->forget(bucket(kCorners, c));
      compacted_->forget(bucket(kForeign, c));
    }
  }
  Vector<std::int64_t> lower;
  for (const VertexId v : lower_.cells.connectivity) {
    lower.push_back(static_cast<std::int64_t>(number_of(v)));
  }
  writer->put(bytes_of(lower));
}

template <class Real>
void Exporter<Real>::put_offsets_and_types(VtuWriter* writer) const {
  const std::uint64_t tets = summary_.tets;
  writer->put_computed<std::int64_t>([&](std::uint64_t first, std::uint64_t count,
                                         std::int64_t* out) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      *out++ = static_cast<std::int64_t>(i < tets ? 4 * (i + 1)
                                                  : 4 * tets + lower_.cells.offsets[i - tets + 1]);
    }
  });
  writer->put_computed<std::uint8_t>(
      [&](std::uint64_t first, std::uint64_t count, std::uint8_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) {
          *out++ = i < tets ? kVtkTetra : lower_.cells.types[i - tets];
        }
      });
}

template <class Real>
void Exporter<Real>::write() {
  OutputFile file(settings_.path, VtuWriter::access(settings_.encoding));
  VtuWriter writer(&file, layout_of_file(), settings_.progress);
  const auto put = [&](std::span<const std::byte> bytes) { writer.put(bytes); };
  std::uint32_t section = kFirstColumn;
  for (std::size_t c = 0; c < layout_.point_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (!lower_.loose_ids.empty()) writer.put(lower_.loose_columns[c].rows);
  }
  for (std::size_t c = 0; c < layout_.cell_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (lower_.cells.size() > 0) writer.put(lower_.columns[c].rows);
  }
  for_each_piece(kPositions, put);
  writer.put(bytes_of(lower_.loose_positions));
  put_corners(&writer);
  put_offsets_and_types(&writer);
  writer.finish();
  compacted_.reset();
  file.commit();
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
