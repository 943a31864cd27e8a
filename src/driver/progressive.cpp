#include "driver/progressive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <queue>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/numbers.h"
#include "driver/windows.h"
#include "io/mesh_stream.h"
#include "io/progressive_file.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;

std::uint64_t row_bytes_of(const AttributeSet& set) {
  std::uint64_t bytes = 0;
  for (const ArrayInfo& info : set.arrays) bytes += info.components * size_of(info.type);
  return bytes;
}

// A vector of rows of one length, in another order.
Vector<std::byte> permuted(const Vector<std::byte>& rows, std::size_t stride,
                           const Vector<std::uint32_t>& order) {
  Vector<std::byte> out(order.size() * stride);
  for (std::size_t i = 0; i < order.size() && stride > 0; ++i) {
    std::memcpy(out.data() + i * stride, rows.data() + std::size_t{order[i]} * stride, stride);
  }
  return out;
}

template <class T>
Vector<std::uint32_t> ascending(const Vector<T>& numbers) {
  auto order = count_up<std::uint32_t>(numbers.size());
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return numbers[a] < numbers[b]; });
  return order;
}

template <class T>
Vector<T> chosen(const Vector<T>& values, const Vector<std::uint32_t>& order) {
  Vector<T> out(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) out[i] = values[order[i]];
  return out;
}

// Rows side by side, of columns one after another.
void append_rows(std::span<const Column> columns, std::size_t row, Vector<std::byte>* out) {
  for (const Column& c : columns) {
    const std::byte* begin = c.rows.data() + row * c.stride();
    out->insert(out->end(), begin, begin + c.stride());
  }
}

template <class T>
void append_bytes(const T& value, Vector<std::byte>* out) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  out->insert(out->end(), bytes.begin(), bytes.end());
}

template <class Real>
class Recorder {
 public:
  Recorder(const MacroLod<Real>& mesh, const WorkMesh<Real>& layout, const LowerPart<Real>& lower,
           std::uint64_t points)
      : mesh_(mesh), layout_(layout), lower_(lower) {
    known_.assign(points, 0);
  }

  void gather_base();
  void note_points(const RoundLogs& logs);
  void put_base(ProgressiveWriter* writer);
  LowerRows lower_rows() const;
  PointRows read_spare(const MeshStream& stream, const CarriedArrays& carried) const;

 private:
  void add_chunk(const WorkMesh<Real>& chunk);

  const MacroLod<Real>& mesh_;
  const WorkMesh<Real>& layout_;
  const LowerPart<Real>& lower_;
  Vector<std::uint8_t> known_;  // points that are somewhere in the file
  PointRows points_;
  TetRows tets_;
};

template <class Real>
void Recorder<Real>::add_chunk(const WorkMesh<Real>& chunk) {
  const std::size_t point_row = point_row_bytes(chunk), tet_row = tet_row_bytes(chunk);
  for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
    const VertexId id = chunk.point_ids[v];
    if (known_[id] != 0 || chunk.incidence[v] == 0) continue;
    known_[id] = 1;
    points_.numbers.push_back(id);
    points_.rows.resize(points_.rows.size() + point_row);
    copy_point_row(chunk, v, points_.rows.data() + points_.rows.size() - point_row);
  }
  const std::span<const TetId> numbers = original_numbers(chunk);
  for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
    Tet tet = chunk.tets[t];
    for (VertexId& v : tet) v = chunk.point_ids[v];
    tets_.numbers.push_back(numbers[t]);
    tets_.corners.push_back(tet);
    tets_.rows.resize(tets_.rows.size() + tet_row);
    copy_tet_row(chunk, t, tets_.rows.data() + tets_.rows.size() - tet_row);
  }
}

template <class Real>
void Recorder<Real>::gather_base() {
  if (mesh_.whole) {
    add_chunk(*mesh_.whole);
  } else {
    ChunkGather<Real> gather;
    WorkMesh<Real> chunk(layout_);
    for (std::uint32_t c = 0; c < mesh_.chunks; ++c) {
      Rounds<Real>::gather(mesh_, c, &gather, &chunk);
      add_chunk(chunk);
    }
  }
  for (std::size_t i = 0; i < lower_.loose_ids.size(); ++i) {
    known_[lower_.loose_ids[i]] = 1;
    points_.numbers.push_back(lower_.loose_ids[i]);
    append_bytes(lower_.loose_positions[i], &points_.rows);
    append_rows(lower_.loose_columns, i, &points_.rows);
  }
}

template <class Real>
void Recorder<Real>::note_points(const RoundLogs& logs) {
  for (const std::vector<FusionLog>& round : logs) {
    for (const FusionLog& log : round) {
      for (std::size_t i = 0; i < log.size(); ++i) {
        for (const VertexId v : log[i].points) known_[v] = 1;
      }
    }
  }
}

template <class Real>
void Recorder<Real>::put_base(ProgressiveWriter* writer) {
  const Vector<std::uint32_t> points = ascending(points_.numbers);
  writer->put_points(
      {chosen(points_.numbers, points), permuted(points_.rows, point_row_bytes(layout_), points)});
  points_ = {};
  const Vector<std::uint32_t> tets = ascending(tets_.numbers);
  writer->put_tets({chosen(tets_.numbers, tets), chosen(tets_.corners, tets),
                    permuted(tets_.rows, tet_row_bytes(layout_), tets)});
  tets_ = {};
}

template <class Real>
LowerRows Recorder<Real>::lower_rows() const {
  LowerRows out;
  out.cells = lower_.cells;
  if (out.cells.size() == 0) return out;
  const Column& numbers = lower_.columns.back();
  out.numbers.resize(out.cells.size());
  std::memcpy(out.numbers.data(), numbers.rows.data(), numbers.rows.size());
  for (std::size_t i = 0; i < out.cells.size(); ++i) {
    append_rows(std::span(lower_.columns).first(lower_.columns.size() - 1), i, &out.rows);
  }
  return out;
}

// Those of the input that are nowhere else.
template <class Real>
PointRows Recorder<Real>::read_spare(const MeshStream& stream, const CarriedArrays& carried) const {
  PointRows spare;
  if (std::find(known_.begin(), known_.end(), 0) == known_.end()) return spare;
  std::vector<Column> columns = layout_.point_columns;
  Vector<Vec3<Real>> positions;
  for (std::uint64_t first = 0; first < known_.size(); first += kWindow) {
    const std::uint64_t count = std::min<std::uint64_t>(kWindow, known_.size() - first);
    const auto begin = known_.begin() + static_cast<std::ptrdiff_t>(first);
    if (std::find(begin, begin + static_cast<std::ptrdiff_t>(count), 0) ==
        begin + static_cast<std::ptrdiff_t>(count)) {
      continue;
    }
    positions.resize(count);
    stream.read_points(first, count, std::as_writable_bytes(std::span(positions)));
    read_columns(stream, Association::kPoint, carried.point_indices, first, count, &columns);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (known_[first + i] != 0) continue;
      spare.numbers.push_back(static_cast<VertexId>(first + i));
      append_bytes(positions[i], &spare.rows);
      append_rows(columns, i, &spare.rows);
    }
  }
  return spare;
}

// The tetrahedra of the input that an import winds the other way round (mesh/chunk_inspection.h).
template <class Real>
Vector<TetId> find_rewound(const MeshStream& stream) {
  Vector<Vec3<Real>> positions(stream.points());
  stream.read_points(0, stream.points(), std::as_writable_bytes(std::span(positions)));
  Vector<TetId> rewound;
  CellWindow window;
  for (std::uint64_t first = 0; first < stream.cells(); first += kWindow) {
    stream.read_cells(first, std::min(kWindow, stream.cells() - first), &window);
    for (std::size_t i = 0; i < window.tets.size(); ++i) {
      Tet sorted = window.tets[i];
      if (determinant(positions, window.tets[i]).sign() >= 0) continue;
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) continue;
      rewound.push_back(
          static_cast<TetId>(window.tet_rows.empty() ? first + i : window.tet_rows[i]));
    }
  }
  return rewound;
}

// What a product in single precision may lack.
constexpr double kRoundedUp = 1 + 1e-7;

// Whose turn it is: the log of which the smallest share has been undone.
struct Turn {
  double share;
  std::size_t log;
  std::uint64_t undone;                      // tetrahedra
  std::size_t left;                          // records
  bool operator<(const Turn& other) const {  // for a queue that has the largest in front
    return share != other.share ? share > other.share : log > other.log;
  }
};

void put_round(const std::vector<FusionLog>& logs, double scale, ProgressiveWriter* writer) {
  std::priority_queue<Turn> turns;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (logs[i].size() > 0) turns.push({0, i, 0, logs[i].size()});
  }
  while (!turns.empty()) {
    Turn turn = turns.top();
    turns.pop();
    const FusionLog& log = logs[turn.log];
    FusionRecord record = log[--turn.left];
    if (scale != 1) record.error = static_cast<float>(record.error * scale * kRoundedUp);
    writer->put(record);
    if (turn.left == 0) continue;
    turn.undone += record.tets.size();
    turn.share = static_cast<double>(turn.undone) / static_cast<double>(log.tets());
    turns.push(turn);
  }
}

ProgressiveDescription describe(const CarriedArrays& carried, FusionErrors errors,
                                MeshSource* source) {
  ProgressiveDescription out;
  out.errors = errors;
  out.point_type = source->description().point_type;
  out.point_data = carried.point_data;
  out.cell_data = carried.cell_data;
  const AttributeSet& fields = source->description().field_data;
  for (std::size_t i = 0; i < fields.arrays.size(); ++i) {
    out.field_data.push_back(source->read_array(Association::kField, i));
  }
  return out;
}

// Of a fusion, which deletes five or more: what leads to its parts, the rows of two points, its
// star; of a tetrahedron its number, corners and row. Vectors have up to twice the room.
std::uint64_t log_bytes_per_tet(const MeshDescription& mesh) {
  const std::uint64_t point = 3 * size_of(mesh.point_type) + row_bytes_of(mesh.point_data);
  return 2 * ((60 + 4 + 30 + 2 * point) / 5 + 12 + row_bytes_of(mesh.cell_data));
}

}  // namespace

void include_logs(const SimplifyRequest& request, const MeshDescription& mesh, std::uint64_t total,
                  MemoryNeeds* needs) {
  needs->in_core += mesh.cells * log_bytes_per_tet(mesh);
  if (request.performance.on_disk) {
    throw Error(ErrorCode::kUsage,
                "--progressive needs the mesh in memory: it cannot be kept on disk yet");
  }
  if (needs->in_core <= total) return;
  throw Error(
      ErrorCode::kMemory,
      fmt::format("{}: with --progressive the mesh and its fusions are kept in memory, which "
                  "needs about {}, but it may use {}: give --memory {}M or more, or leave "
                  "out --progressive",
                  request.input, format_bytes(needs->in_core), format_bytes(total),
                  (needs->in_core >> 20) + 1));
}

void refuse_ghosts(const std::string& input, const InputFacts& facts) {
  if (facts.ghost_cells == 0) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: {} cells are ghosts, which a progressive file cannot bring back: "
                          "leave out --progressive, or convert the mesh first",
                          input, format_count(facts.ghost_cells)));
}

template <class Real>
void write_progressive(const WorkMesh<Real>& layout, const CarriedArrays& carried,
                       const RoundLogs& logs, const NotedErrors& errors, MeshSource* source,
                       const RunContext& context, ImportedMesh<Real>* mesh, OutputFile* file) {
  const auto stream = open_stream(source);
  auto rows = layout;
  rows.cell_columns.push_back(number_column());
  Recorder<Real> recorder(mesh->mesh, rows, mesh->lower, stream->points());
  recorder.gather_base();
  recorder.note_points(logs);
  ProgressiveWriter writer(file, describe(carried, errors.kind, source));
  recorder.put_base(&writer);
  writer.put_lower(recorder.lower_rows());
  writer.put_spare(recorder.read_spare(*stream, carried));
  // Those that are inverted were wound the other way, too.
  if (mesh->facts.rewound + mesh->facts.inverted > 0)
    writer.put_rewound(find_rewound<Real>(*stream));
  for (auto round = logs.rbegin(); round != logs.rend(); ++round) {
    context.check();
    put_round(*round, errors.scale, &writer);
  }
  writer.finish();
  mesh->lower.columns.pop_back();
}

template void write_progressive(const WorkMesh<float>&, const CarriedArrays&, const RoundLogs&,
                                const NotedErrors&, MeshSource*, const RunContext&,
                                ImportedMesh<float>*, OutputFile*);
template void write_progressive(const WorkMesh<double>&, const CarriedArrays&, const RoundLogs&,
                                const NotedErrors&, MeshSource*, const RunContext&,
                                ImportedMesh<double>*, OutputFile*);

}  // namespace tetfusion
