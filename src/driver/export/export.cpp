#include "driver/export/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "driver/export/export_chunks.h"
#include "driver/export/export_memory.h"
#include "driver/export/export_pieces.h"
#include "io/left_out.h"
#include "io/mesh_output.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/pieces_output.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

namespace {

// The sections of the file that come from chunks, in the order in which the columns follow.
enum FileSection : std::uint32_t { kFilePositions, kFileCorners, kFirstFileColumn };

template <class Real>
class Exporter {
 public:
  explicit Exporter(const ExportJob<Real>& job) : job_(job), chunks_(job) {}

  MeshSummary run() {
    const CellOrder all = cells();
    const auto& inspect = job_.settings.inspect;
    MeshOutput output(job_.settings.path, job_.settings.encoding, inspect != nullptr,
                      job_.settings.label);
    vtu_share_ = output.vtu_share();
    VtuLayout layout = layout_of_output(job_, chunks_.summary().points, all.size(),
                                        4 * all.tets + job_.lower.cells.connectivity.size());
    layout.encoding = output.encoding();
    VtuWriter writer(output.file(), layout, [this](double done) {
      if (chunks_share_ < vtu_share_) {
        job_.report(chunks_share_ + (vtu_share_ - chunks_share_) * done);
      }
    });
    if (writer.can_leave_room()) {
      write_in_place(&writer, output.file());
    } else {
      write_in_order(&writer);
    }
    job_.check();
    writer.finish();
    if (inspect) inspect(output.file()->path_to_read(), chunks_.summary());
    output.commit([this](double done) { job_.report(done); },
                  [this](std::string_view what) { job_.context.say(what); },
                  job_.settings.before_name);
    return chunks_.summary();
  }

 private:
  using Chunk = typename ExportChunks<Real>::Chunk;
  // Where in the file the values of the chunks' sections begin.
  struct Places {
    std::vector<std::uint64_t> sections;
    std::uint64_t offsets = 0;
    std::uint64_t types = 0;
  };

  void write_in_place(VtuWriter* writer, const OutputFile* file);
  void place_chunk(const Chunk& chunk, const Places& places, const OutputFile& file) const;
  void place_lower(const Places& places, const OutputFile& file) const;

  void write_in_order(VtuWriter* writer);
  void store_chunk(const Chunk& chunk);
  template <class F>
  void for_each_piece(std::uint32_t section, F put);

  CellOrder cells() const { return {chunks_.summary().tets, &job_.lower.cells}; }

  const ExportJob<Real>& job_;
  ExportChunks<Real> chunks_;
  std::unique_ptr<PieceStore> compacted_;
  // Of the work: writing a .vtu, and as a part of that going through the chunks.
  double vtu_share_ = 1;
  double chunks_share_ = 1;
};

// Raw values have places that are known from the start: chunks write themselves there, side by
// side.
template <class Real>
void Exporter<Real>::write_in_place(VtuWriter* writer, const OutputFile* file) {
  Places places;
  chunks_share_ = vtu_share_;
  const WorkMesh<Real>& layout = job_.layout;
  places.sections.resize(kFirstFileColumn + layout.point_columns.size() +
                         layout.cell_columns.size());
  // An array without values has no room, and nothing is placed in it.
  const auto leave_room = [&](std::uint64_t values) {
    return values > 0 ? writer->leave_room() : 0;
  };
  const std::uint64_t points = chunks_.summary().points;
  const std::uint64_t rows = cells().size();
  std::size_t section = kFirstFileColumn;
  for (std::size_t c = 0; c < layout.point_columns.size(); ++c) {
    places.sections[section++] = leave_room(points * layout.point_columns[c].components);
  }
  for (std::size_t c = 0; c < layout.cell_columns.size(); ++c) {
    places.sections[section++] = leave_room(rows * layout.cell_columns[c].components);
  }
  places.sections[kFilePositions] = leave_room(points);
  places.sections[kFileCorners] = leave_room(rows);
  places.offsets = leave_room(rows);
  places.types = leave_room(rows);
  chunks_.for_each(chunks_share_, [&](const Chunk& chunk) { place_chunk(chunk, places, *file); });
  place_lower(places, *file);
}

template <class Real>
void Exporter<Real>::place_chunk(const Chunk& chunk, const Places& places,
                                 const OutputFile& file) const {
  const std::uint64_t point = chunks_.first_point(chunk.number);
  const std::uint64_t cell = chunks_.first_tet(chunk.number);
  const auto place = [&](std::uint64_t section, std::uint64_t before,
                         std::span<const std::byte> bytes) {
    file.place(section + before, bytes.data(), bytes.size());
  };
  const WorkMesh<Real>& mesh = chunk.mesh;
  place(places.sections[kFilePositions], point * sizeof(Vec3<Real>),
        bytes_of(positions_of(mesh, chunk.own)));
  std::size_t section = kFirstFileColumn;
  for (const Column& c : mesh.point_columns) {
    place(places.sections[section++], point * c.stride(), rows_of(c, chunk.own));
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
    for (std::size_t k = 0; k < 4; ++k) corners[t][k] = chunk.numbers[mesh.tets[t][k]];
    ends[t] = all.end(cell + t);
    types[t] = all.type(cell + t);
  }
  place(places.sections[kFileCorners], cell * sizeof(corners[0]), bytes_of(corners));
  place(places.offsets, cell * sizeof(ends[0]), bytes_of(ends));
  place(places.types, cell, bytes_of(types));
}

template <class Real>
void Exporter<Real>::place_lower(const Places& places, const OutputFile& file) const {
  const LowerPart<Real>& lower = job_.lower;
  const std::uint64_t point = chunks_.first_point(chunks_.chunks());
  const std::uint64_t cell = chunks_.first_tet(chunks_.chunks());
  const auto place = [&](std::uint64_t offset, std::span<const std::byte> bytes) {
    if (!bytes.empty()) file.place(offset, bytes.data(), bytes.size());
  };
  place(places.sections[kFilePositions] + point * sizeof(Vec3<Real>),
        bytes_of(lower.loose_positions));
  std::size_t section = kFirstFileColumn;
  for (const Column& c : lower.loose_columns) {
    place(places.sections[section++] + point * c.stride(), c.rows);
  }
  section = kFirstFileColumn + job_.layout.point_columns.size();
  for (const Column& c : lower.columns) {
    place(places.sections[section++] + cell * c.stride(), c.rows);
  }
  Vector<std::int64_t> ends;
  ends.reserve(lower.cells.size());
  for (std::uint64_t i = 0; i < lower.cells.size(); ++i) ends.push_back(cells().end(cell + i));
  place(places.sections[kFileCorners] + 4 * cell * sizeof(std::int64_t),
        bytes_of(chunks_.lower_corners()));
  place(places.offsets + cell * sizeof(std::int64_t), bytes_of(ends));
  place(places.types + cell,
        lower.cells.size() > 0 ? bytes_of(lower.cells.types) : std::span<const std::byte>());
}

// What is encoded, or goes to a stream, must be written in the order of the file: chunks are put
// away by sections, and each section is put together from them.
template <class Real>
void Exporter<Real>::write_in_order(VtuWriter* writer) {
  const WorkMesh<Real>& layout = job_.layout;
  const LowerPart<Real>& lower = job_.lower;
  chunks_share_ = 0.4 * vtu_share_;
  compacted_ = job_.scratch->begin(fmt::format("output-{}", job_.mesh.tets));
  chunks_.for_each(chunks_share_, [&](const Chunk& chunk) { store_chunk(chunk); });
  compacted_->seal();
  const auto put = [&](std::span<const std::byte> bytes) { writer->put(bytes); };
  std::uint32_t section = kFirstFileColumn;
  for (std::size_t c = 0; c < layout.point_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (!lower.loose_ids.empty()) writer->put(lower.loose_columns[c].rows);
  }
  for (std::size_t c = 0; c < layout.cell_columns.size(); ++c) {
    for_each_piece(section++, put);
    if (lower.cells.size() > 0) writer->put(lower.columns[c].rows);
  }
  for_each_piece(kFilePositions, put);
  writer->put(bytes_of(lower.loose_positions));
  Vector<std::int64_t> corners;
  for_each_piece(kFileCorners, [&](std::span<const std::byte> bytes) {
    const auto* numbers = reinterpret_cast<const std::uint32_t*>(bytes.data());
    corners.assign(numbers, numbers + bytes.size() / sizeof(std::uint32_t));
    writer->put(bytes_of(corners));
  });
  writer->put(bytes_of(chunks_.lower_corners()));
  put_ends_and_types(cells(), writer);
  compacted_.reset();
}

// Each section is a piece of its own: bucket = section * chunks + chunk.
template <class Real>
void Exporter<Real>::store_chunk(const Chunk& chunk) {
  const WorkMesh<Real>& mesh = chunk.mesh;
  const auto bucket = [&](std::uint32_t section) {
    return section * chunks_.chunks() + chunk.number;
  };
  const Vector<Vec3<Real>> positions = positions_of(mesh, chunk.own);
  Vector<Tet> corners = mesh.tets;
  for (Tet& t : corners) {
    for (VertexId& v : t) v = chunk.numbers[v];
  }
  std::vector<Vector<std::byte>> rows;
  for (const Column& c : mesh.point_columns) rows.push_back(rows_of(c, chunk.own));
  std::vector<PieceRef> pieces{{bucket(kFilePositions), bytes_of(positions)},
                               {bucket(kFileCorners), bytes_of(corners)}};
  std::uint32_t section = kFirstFileColumn;
  for (const Vector<std::byte>& r : rows) pieces.push_back({bucket(section++), r});
  for (const Column& c : mesh.cell_columns) {
    pieces.push_back({bucket(section++), {c.rows.data(), mesh.tets.size() * c.stride()}});
  }
  std::erase_if(pieces, [](const PieceRef& p) { return p.bytes.empty(); });
  compacted_->add(chunk.number, pieces);
}

// Calls put(bytes) for a section of all chunks, in order, and drops it.
template <class Real>
template <class F>
void Exporter<Real>::for_each_piece(std::uint32_t section, F put) {
  for (std::uint32_t c = 0; c < chunks_.chunks(); ++c) {
    job_.context.check();
    const std::uint32_t bucket = section * chunks_.chunks() + c;
    if (compacted_->bytes(bucket) == 0) continue;
    put(compacted_->read(bucket)->pieces()[0]);
    compacted_->forget(bucket);
  }
}

template <class Real>
MeshSummary export_as_it_is(const ExportJob<Real>& job) {
  if (job.settings.sink != nullptr) return export_to_memory(job);
  return is_pieces_name(job.settings.path) ? export_pieces(job) : Exporter<Real>(job).run();
}

// Points that only cells of lower dimension use have stayed.
template <class Real>
void add_original_ids(WorkMesh<Real>* rows, LowerPart<Real>* lower, CarriedArrays* arrays) {
  arrays->point_data.arrays.push_back(original_ids_info());
  rows->point_columns.push_back({ValueType::kInt64, 1, {}});
  lower->loose_columns.push_back(
      column_of(Vector<std::int64_t>(lower->loose_ids.begin(), lower->loose_ids.end())));
}

}  // namespace

ArrayInfo original_ids_info() { return {kOriginalIds, ValueType::kInt64, 1, {}, 0}; }

void require_no_original_ids(const std::string& input, const MeshDescription& mesh) {
  if (mesh.point_data.find(kOriginalIds) == AttributeSet::npos) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: the mesh has an array {} already: leave --original-ids out, or "
                          "rename or remove the array",
                          input, kOriginalIds));
}

void check_export(const std::string& path, Encoding encoding) {
  if (is_pieces_name(path)) {
    check_pieces_output(path);
  } else {
    check_mesh_output(path, encoding);
  }
}

void tell_left_out(const std::string& path, const MeshDescription& mesh, const std::string& label,
                   const RunContext& context) {
  const std::string left_out =
      is_pieces_name(path) ? unread_of(mesh) : left_out_of(path, mesh, label);
  if (!left_out.empty()) context.say(left_out);
  const auto ids = mesh.point_data.active.find("GlobalIds");
  if (!is_pieces_name(path) || ids == mesh.point_data.active.end()) return;
  const auto& active = with_global_ids(mesh.point_data).active;
  context.say(
      fmt::format("pieces are joined by array {}, so that it has the mark GlobalIds in "
                  "place of {}, whose values stay{}",
                  active.at("GlobalIds"), ids->second,
                  active.at("PedigreeIds") == ids->second ? " (marked PedigreeIds)" : ""));
}

void clear_leftovers(const std::string& path) noexcept {
  if (is_pieces_name(path)) remove_dead_pieces(path);
}

template <class Real>
MeshSummary export_mesh(const ExportJob<Real>& job) {
  if (!job.settings.original_ids) return export_as_it_is(job);
  WorkMesh<Real> layout = job.layout;
  LowerPart<Real> lower = job.lower;
  CarriedArrays carried = job.carried;
  add_original_ids(&layout, &lower, &carried);
  return export_as_it_is<Real>({job.mesh, layout, lower, carried, job.fitted, job.source,
                                job.settings, job.context, job.budget, job.scratch});
}

template MeshSummary export_mesh(const ExportJob<float>&);
template MeshSummary export_mesh(const ExportJob<double>&);

}  // namespace tetfusion
