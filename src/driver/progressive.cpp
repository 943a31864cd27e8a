#include "driver/progressive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "driver/progressive_base.h"
#include "driver/windows.h"
#include "io/progressive_file.h"
#include "io/stream_windows.h"

namespace tetfusion {

namespace {

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
PointRows loose_points(const LowerPart<Real>& lower) {
  PointRows points;
  for (std::size_t i = 0; i < lower.loose_ids.size(); ++i) {
    points.numbers.push_back(lower.loose_ids[i]);
    append_bytes(lower.loose_positions[i], &points.rows);
    append_rows(lower.loose_columns, i, &points.rows);
  }
  return points;
}

template <class Real>
LowerRows lower_rows(const LowerPart<Real>& lower) {
  LowerRows out;
  out.cells = lower.cells;
  if (out.cells.size() == 0) return out;
  const Column& numbers = lower.columns.back();
  out.numbers.resize(out.cells.size());
  std::memcpy(out.numbers.data(), numbers.rows.data(), numbers.rows.size());
  for (std::size_t i = 0; i < out.cells.size(); ++i) {
    append_rows(std::span(lower.columns).first(lower.columns.size() - 1), i, &out.rows);
  }
  return out;
}

// The points of the input that are nowhere else.
template <class Real>
void put_spare(const MeshStream& stream, const CarriedArrays& carried, const WorkMesh<Real>& layout,
               const std::vector<bool>& known, ProgressiveWriter* writer) {
  std::vector<Column> columns = layout.point_columns;
  Vector<Vec3<Real>> positions;
  for_each_window(known.size(), RunContext(), [&](std::uint64_t first, std::uint64_t count) {
    const auto begin = known.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(count);
    if (std::find(begin, end, false) == end) return;
    positions.resize(count);
    stream.read_points(first, count, std::as_writable_bytes(std::span(positions)));
    read_columns(stream, Association::kPoint, carried.point_indices, first, count, &columns);
    PointRows spare;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (known[first + i]) continue;
      spare.numbers.push_back(static_cast<VertexId>(first + i));
      append_bytes(positions[i], &spare.rows);
      append_rows(columns, i, &spare.rows);
    }
    writer->put_spare(spare);
  });
}

void put_rewound(const std::vector<bool>& rewound, ProgressiveWriter* writer) {
  for (std::size_t t = 0; t < rewound.size(); ++t) {
    const auto number = static_cast<TetId>(t);
    if (rewound[t]) writer->put_rewound({&number, 1});
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

// What writing takes beside a chunk in hand: a slice of the logs as pieces and taken apart, or so a
// range of the result; sections that wait to be packed, and packed.
std::uint64_t writing_bytes(const MeshDescription& mesh, int threads) {
  constexpr std::uint64_t kRows = std::uint64_t{1} << 16;
  const std::uint64_t point = 4 + 3 * size_of(mesh.point_type) + mesh.point_data.row_bytes();
  const std::uint64_t section = kRows * std::max(point, 20 + mesh.cell_data.row_bytes());
  return 3 * std::max(FusionLogs::kSliceBytes, ProgressiveBase<float>::kRangeBytes) +
         4 * static_cast<std::uint64_t>(threads) * section;
}

// One for each point, and for each cell.
std::uint64_t bits_bytes(const MeshDescription& mesh) { return (mesh.points + mesh.cells) / 8 + 2; }

}  // namespace

// Of a fusion, which deletes five or more: what leads to its parts, the rows of two points, its
// star; of a tetrahedron its number, corners and row. Vectors have up to twice the room.
std::uint64_t log_bytes_per_tet(const MeshDescription& mesh) {
  const std::uint64_t point = 3 * size_of(mesh.point_type) + mesh.point_data.row_bytes();
  return 2 * ((60 + 4 + 30 + 2 * point) / 5 + 12 + mesh.cell_data.row_bytes());
}

void include_logs(const SimplifyRequest& request, const MeshDescription& mesh, int threads,
                  MemoryNeeds* needs) {
  const std::uint64_t logs = mesh.cells * log_bytes_per_tet(mesh);
  const std::uint64_t in_hand = static_cast<std::uint64_t>(threads) *
                                std::min(mesh.cells, request.behaviour.chunk_tets) *
                                log_bytes_per_tet(mesh);
  const std::uint64_t bits = bits_bytes(mesh);
  const std::uint64_t writing = writing_bytes(mesh, threads) + bits;
  needs->in_core += logs + writing;
  needs->out_of_core = std::max(needs->out_of_core + in_hand + bits, kProcessBytes + writing);
  needs->scratch += logs + mesh.cells * sizeof(TetId);
}

void refuse_ghosts(const std::string& input, const InputFacts& facts) {
  if (facts.ghost_cells == 0) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: it has {}, which a progressive file cannot bring back: leave out "
                          "--progressive, or convert the mesh first",
                          input, format_count(facts.ghost_cells, "ghost cell")));
}

template <class Real>
void write_progressive(const ProgressiveJob<Real>& job, OutputFile* file) {
  const auto stream = open_stream(job.source);
  auto rows = job.layout;
  rows.cell_columns.push_back(number_column());
  std::vector<bool> known(stream->points());
  MemoryBudget::Reservation memory;
  ProgressiveWriter writer(file, describe(job.carried, job.errors, job.source));
  LowerPart<Real>& lower = job.mesh->lower;
  {
    ProgressiveBase<Real> base(rows, stream->points(), stream->cells(), job.scratch);
    base.add(job.mesh->mesh, job.budget);
    base.add(loose_points(lower));
    base.end();
    trim_memory();
    job.context.check();
    memory = job.budget->reserve(writing_bytes(job.source->description(), thread_count()),
                                 "writing the progressive file");
    base.put_points(&writer, &known);
    base.put_tets(&writer);
  }
  writer.put_lower(lower_rows(lower));
  job.logs->take_backwards([&](FusionRecord record, std::uint32_t round, std::uint32_t chunk) {
    for (const VertexId v : record.points) known[v] = true;
    writer.put(record, round, chunk);
  });
  job.context.check();
  put_spare<Real>(*stream, job.carried, rows, known, &writer);
  put_rewound(job.mesh->rewound, &writer);
  writer.finish();
  file->finish();
  lower.columns.pop_back();
}

template void write_progressive(const ProgressiveJob<float>&, OutputFile*);
template void write_progressive(const ProgressiveJob<double>&, OutputFile*);

}  // namespace tetfusion
