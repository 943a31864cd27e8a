#include "driver/export/progressive.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "driver/export/progressive_base.h"
#include "driver/rounds/windows.h"
#include "io/progressive/progressive_file.h"
#include "io/source/stream_windows.h"

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
  out.numbers = lower.numbers;
  for (std::size_t i = 0; i < out.cells.size(); ++i) append_rows(lower.columns, i, &out.rows);
  return out;
}

// The points of the input that are nowhere else.
template <class Real>
void put_spare(const ProgressiveJob<Real>& job, const MeshStream& stream,
               const std::vector<bool>& known, ProgressiveWriter* writer) {
  std::vector<Column> columns = job.layout.point_columns;
  Vector<Vec3<Real>> positions;
  for_each_window(known.size(), job.context, [&](std::uint64_t first, std::uint64_t count) {
    const auto begin = known.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(count);
    if (std::find(begin, end, false) == end) return;
    positions.resize(count);
    stream.read_points(first, count, std::as_writable_bytes(std::span(positions)));
    read_columns(stream, Association::kPoint, job.carried.point_indices, first, count, &columns);
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

void put_rewound(const std::vector<bool>& rewound, const RunContext& context,
                 ProgressiveWriter* writer) {
  for_each_window(rewound.size(), context, [&](std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t t = first; t < first + count; ++t) {
      const auto number = static_cast<TetId>(t);
      if (rewound[t]) writer->put_rewound({&number, 1});
    }
  });
}

// Takes the logs of so many tetrahedra, backwards. The points are noted in `known`.
void put_fusions(std::uint64_t tets, const RunContext& context, FusionLogs* logs,
                 ProgressiveWriter* writer, std::vector<bool>* known) {
  std::uint64_t undone = 0, told = 0;
  logs->take_backwards([&](const FusionRecord& record, std::uint32_t round, std::uint32_t chunk) {
    context.check();
    for (const VertexId v : record.points) (*known)[v] = true;
    writer->put(record, round, chunk);
    undone = std::min(undone + record.tets.size(), tets);
    if (undone * 100 / tets == told) return;
    told = undone * 100 / tets;
    context.report(kWayBackPhase, 0, 1, undone, tets);
  });
}

ProgressiveDescription describe(const CarriedArrays& carried, FusionErrors errors,
                                MeshSource* source) {
  ProgressiveDescription out;
  out.errors = errors;
  out.point_type = source->description().point_type;
  out.point_data = carried.point_data;
  out.cell_data = carried.cell_data;
  out.field_data = source->read_field_data();
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
  // Field data once more, and as it is encoded.
  const std::uint64_t writing = writing_bytes(mesh, threads) + bits + 2 * mesh.field_data.bytes();
  needs->in_core += logs + writing;
  needs->out_of_core = std::max(needs->out_of_core + in_hand + bits,
                                kProcessBytes + writing + mesh.field_data.bytes());
  needs->scratch += logs;
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
  const RunContext& context = job.context;
  context.report(kWayBackPhase, 0);
  const auto stream = open_stream(job.source);
  auto rows = job.layout;
  rows.cell_columns.push_back(number_column());
  std::vector<bool> known(stream->points());
  MemoryBudget::Reservation memory;
  ProgressiveWriter writer(file, describe(job.carried, job.errors, job.source));
  const MacroLod<Real>& mesh = job.mesh;
  const LowerPart<Real>& lower = job.input.lower;
  const std::uint64_t tets = std::max<std::uint64_t>(job.input.facts.tets, 1);
  // Of the work, as far as it is told: the result, and half of that till it is sorted.
  const double base_share = static_cast<double>(mesh.tets) / static_cast<double>(tets);
  {
    ProgressiveBase<Real> base(rows, stream->points(), stream->cells(), job.scratch);
    base.add(mesh, context.part(0, base_share / 2), job.budget);
    base.add(loose_points(lower));
    base.end();
    trim_memory();
    context.check();
    memory = job.budget->reserve(writing_bytes(job.source->description(), thread_count()),
                                 "writing the progressive file");
    base.put_points(context.part(base_share / 2, 0.75 * base_share), &writer, &known);
    base.put_tets(context.part(0.75 * base_share, base_share), &writer);
  }
  writer.put_lower(lower_rows(lower));
  put_fusions(tets - mesh.tets, context.part(base_share, 1), job.logs, &writer, &known);
  put_spare<Real>(job, *stream, known, &writer);
  put_rewound(job.input.rewound, context, &writer);
  writer.finish();
  file->finish();
}

template void write_progressive(const ProgressiveJob<float>&, OutputFile*);
template void write_progressive(const ProgressiveJob<double>&, OutputFile*);

}  // namespace tetfusion
