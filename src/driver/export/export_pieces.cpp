#include "driver/export/export_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>

#include "io/files/output_file.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/pieces_output.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

namespace {

// Of the work: going through the chunks.
constexpr double kChunksShare = 0.4;
// A piece of about 100 MB without arrays.
constexpr std::uint64_t kTetsPerPiece = 4'000'000;

enum PieceSection : std::uint32_t { kPositions, kNumbers, kCorners, kFirstColumn };

// The tetrahedra of a chunk that go to the same piece.
struct Slice {
  std::uint32_t chunk = 0;
  std::uint64_t first = 0;  // of the chunk's
  std::uint64_t tets = 0;
  // Known when it has been stored. The first `shared` points may be in other slices, too.
  std::uint64_t points = 0;
  std::uint64_t shared = 0;
};

// Slices, put away by sections: each section of each slice is a bucket of its own.
class StoredSlices {
 public:
  std::vector<Slice> slices;  // ascending
  std::unique_ptr<PieceStore> store;

  std::uint32_t bucket(std::size_t section, std::size_t slice) const {
    return static_cast<std::uint32_t>(section * slices.size() + slice);
  }
  // Calls use(bytes) with the values of a section, where it has any.
  template <class F>
  void read(std::size_t section, std::size_t slice, F use) const {
    const std::uint32_t at = bucket(section, slice);
    if (store->bytes(at) > 0) use(store->read(at)->pieces()[0]);
  }
  void forget(std::size_t slice, std::size_t sections) {
    for (std::size_t i = 0; i < sections; ++i) store->forget(bucket(i, slice));
  }
};

// Which points of a piece's slices are written, and where they come in the piece: a shared one is
// written with the first slice that has it.
struct PieceNumbers {
  Vector<std::uint32_t> places;      // in the piece, of the shared points of all slices
  Vector<std::uint8_t> is_first;     // of the same
  std::vector<std::uint64_t> first;  // point of each slice; one entry more
};

PieceNumbers number_points(const StoredSlices& stored, std::size_t begin, std::size_t end) {
  const std::vector<Slice>& slices = stored.slices;
  // A point's number in the result, and its place among the shared points of all slices: where
  // points are the same one the first comes first.
  Vector<std::uint64_t> copies;
  for (std::size_t s = begin; s < end; ++s) {
    stored.read(kNumbers, s, [&](std::span<const std::byte> bytes) {
      const auto* numbers = reinterpret_cast<const std::uint32_t*>(bytes.data());
      for (std::uint64_t i = 0; i < slices[s].shared; ++i) {
        copies.push_back(std::uint64_t{numbers[i]} << 32 | copies.size());
      }
    });
  }
  std::sort(copies.begin(), copies.end());
  PieceNumbers out;
  out.is_first.assign(copies.size(), 0);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (i == 0 || copies[i] >> 32 != copies[i - 1] >> 32) {
      out.is_first[static_cast<std::uint32_t>(copies[i])] = 1;
    }
  }
  out.places.resize(copies.size());
  out.first.push_back(0);
  std::size_t copy = 0;
  for (std::size_t s = begin; s < end; ++s) {
    std::uint64_t next = out.first.back();
    for (const std::size_t last = copy + slices[s].shared; copy < last; ++copy) {
      if (out.is_first[copy] != 0) out.places[copy] = static_cast<std::uint32_t>(next++);
    }
    out.first.push_back(next + slices[s].points - slices[s].shared);
  }
  std::uint32_t place = 0;
  for (const std::uint64_t c : copies) {
    const auto at = static_cast<std::uint32_t>(c);
    if (out.is_first[at] != 0) place = out.places[at];
    out.places[at] = place;
  }
  return out;
}

// Writes slices begin to end as one file.
template <class Real>
class PieceWriter {
 public:
  PieceWriter(const StoredSlices& stored, std::size_t begin, std::size_t end,
              const RunContext& context)
      : stored_(stored),
        begin_(begin),
        end_(end),
        context_(context),
        numbers_(number_points(stored, begin, end)) {
    for (std::size_t s = begin; s < end; ++s) cells_.tets += stored.slices[s].tets;
  }
  std::uint64_t tets() const { return cells_.tets; }

  // `mesh` says what a row holds; the point arrays of `layout` have the global ids as well.
  void write(const std::string& path, VtuLayout layout, const WorkMesh<Real>& mesh,
             std::function<void(double)> progress) {
    layout.points = numbers_.first.back();
    layout.cells = cells_.size();
    layout.corners = 4 * cells_.tets;
    OutputFile file(path, VtuWriter::access(layout.encoding));
    VtuWriter writer(&file, layout, std::move(progress));
    const auto put = [&](std::span<const std::byte> bytes) { writer.put(bytes); };
    std::size_t section = kFirstColumn;
    for (const Column& c : mesh.point_columns) for_each_point(section++, c.stride(), put);
    put_global_ids(&writer);
    for (std::size_t c = 0; c < mesh.cell_columns.size(); ++c) {
      for_each(section++, [&](std::span<const std::byte> bytes, auto...) { writer.put(bytes); });
    }
    for_each_point(kPositions, sizeof(Vec3<Real>), put);
    put_corners(&writer);
    put_ends_and_types(cells_, &writer);
    writer.finish();
    file.commit();
  }

 private:
  // Calls use(bytes, slice, its first shared point) for a section of all slices.
  template <class F>
  void for_each(std::size_t section, F use) const {
    std::size_t copy = 0;
    for (std::size_t s = begin_; s < end_; ++s) {
      context_.check();
      stored_.read(section, s, [&](std::span<const std::byte> bytes) { use(bytes, s, copy); });
      copy += stored_.slices[s].shared;
    }
  }

  // Calls put(bytes) with the rows of points, but for those that an earlier slice has had.
  template <class F>
  void for_each_point(std::size_t section, std::size_t stride, F put) {
    for_each(section, [&](std::span<const std::byte> bytes, std::size_t s, std::size_t copy) {
      const std::uint64_t shared = stored_.slices[s].shared;
      kept_.clear();
      for (std::uint64_t i = 0; i < shared; ++i) {
        if (numbers_.is_first[copy + i] == 0) continue;
        const auto row = bytes.subspan(i * stride, stride);
        kept_.insert(kept_.end(), row.begin(), row.end());
      }
      put(std::span<const std::byte>(kept_));
      put(bytes.subspan(shared * stride));
    });
  }

  void put_global_ids(VtuWriter* writer) {
    for_each_point(kNumbers, sizeof(std::uint32_t), [&](std::span<const std::byte> bytes) {
      Vector<std::uint32_t> ids(bytes.size() / sizeof(std::uint32_t));
      if (!ids.empty()) std::memcpy(ids.data(), bytes.data(), bytes.size());
      values_.assign(ids.begin(), ids.end());
      writer->put(bytes_of(values_));
    });
  }

  void put_corners(VtuWriter* writer) {
    for_each(kCorners, [&](std::span<const std::byte> bytes, std::size_t s, std::size_t copy) {
      const Slice& slice = stored_.slices[s];
      const auto* corners = reinterpret_cast<const std::uint32_t*>(bytes.data());
      values_.resize(bytes.size() / sizeof(std::uint32_t));
      // The points that are not shared are the slice's last ones in the piece, too.
      const std::uint64_t end = numbers_.first[s - begin_ + 1];
      for (std::size_t i = 0; i < values_.size(); ++i) {
        const std::uint64_t v = corners[i];
        const std::uint64_t place =
            v < slice.shared ? numbers_.places[copy + v] : end - (slice.points - v);
        values_[i] = static_cast<std::int64_t>(place);
      }
      writer->put(bytes_of(values_));
    });
  }

  const StoredSlices& stored_;
  std::size_t begin_, end_;
  const RunContext& context_;
  PieceNumbers numbers_;
  CellOrder cells_;
  Vector<std::byte> kept_;
  Vector<std::int64_t> values_;
};

// The points that cells of lower dimension use, of one chunk.
template <class Real>
struct LowerPieceRows {
  Vector<Vec3<Real>> positions;
  std::vector<Vector<std::byte>> columns;
};

template <class Real>
class PiecesExporter {
 public:
  explicit PiecesExporter(const ExportJob<Real>& job)
      : job_(job), chunks_(job), output_(job.settings.path), rows_(chunks_.chunks()) {
    plan_slices();
  }

  MeshSummary run() {
    stored_.store = job_.scratch->begin(fmt::format("output-{}", job_.mesh.tets));
    chunks_.for_each(kChunksShare, [&](const Chunk& chunk) { store_chunk(chunk); });
    stored_.store->seal();
    VtuLayout layout = layout_of_output(job_, 0, 0, 0);
    layout.point_data = with_global_ids(std::move(layout.point_data));
    std::uint32_t pieces = 0;
    while (pieces + 1 < first_slice_.size()) write_piece(pieces++, layout);
    stored_.store.reset();
    if (job_.lower.cells.size() > 0) write_lower(pieces++, layout);
    job_.check();
    if (job_.settings.inspect) {
      job_.settings.inspect(output_.path_to_read(layout, pieces), chunks_.summary());
    }
    output_.commit(layout, pieces, job_.settings.before_name);
    return chunks_.summary();
  }

 private:
  using Chunk = typename ExportChunks<Real>::Chunk;

  void plan_slices();

  void store_chunk(const Chunk& chunk);
  Vector<std::uint32_t> take_slice(const Chunk& chunk, Slice* slice, Vector<std::uint32_t>* local,
                                   Vector<Tet>* corners) const;
  void keep_lower(const Chunk& chunk);

  void write_piece(std::uint32_t piece, const VtuLayout& layout);
  void write_lower(std::uint32_t piece, VtuLayout layout);

  const ExportJob<Real>& job_;
  ExportChunks<Real> chunks_;
  PiecesOutput output_;
  StoredSlices stored_;
  std::vector<std::size_t> first_slice_;     // of each piece; one entry more
  std::vector<std::size_t> first_of_chunk_;  // slice of each chunk; one entry more
  std::vector<LowerPieceRows<Real>> rows_;   // one a chunk
  std::uint64_t written_ = 0;                // tetrahedra
};

template <class Real>
void PiecesExporter<Real>::plan_slices() {
  const std::uint64_t tets = chunks_.summary().tets;
  const std::uint64_t wanted =
      job_.settings.pieces > 0 ? job_.settings.pieces : (tets + kTetsPerPiece - 1) / kTetsPerPiece;
  const std::uint64_t pieces =
      std::clamp<std::uint64_t>(wanted, 1, std::max<std::uint64_t>(tets, 1));
  first_slice_.push_back(0);
  std::uint32_t chunk = 0;
  std::uint64_t done = 0;
  for (std::uint64_t piece = 0; piece < pieces; ++piece) {
    const std::uint64_t end = tets * (piece + 1) / pieces;
    while (done < end) {
      while (chunks_.first_tet(chunk + 1) <= done) ++chunk;
      const std::uint64_t until = std::min(end, chunks_.first_tet(chunk + 1));
      stored_.slices.push_back({chunk, done - chunks_.first_tet(chunk), until - done, 0, 0});
      done = until;
    }
    first_slice_.push_back(stored_.slices.size());
  }
  first_of_chunk_.push_back(0);
  for (std::uint32_t c = 0; c < chunks_.chunks(); ++c) {
    std::size_t end = first_of_chunk_.back();
    while (end < stored_.slices.size() && stored_.slices[end].chunk == c) ++end;
    first_of_chunk_.push_back(end);
  }
}

// The points of a slice, the shared ones first, and its tetrahedra by them. `local` has an entry
// for each vertex of the chunk, kNoVertex, and has so again afterwards.
template <class Real>
Vector<std::uint32_t> PiecesExporter<Real>::take_slice(const Chunk& chunk, Slice* slice,
                                                       Vector<std::uint32_t>* local,
                                                       Vector<Tet>* corners) const {
  const auto tets = std::span(chunk.mesh.tets).subspan(slice->first, slice->tets);
  Vector<std::uint32_t> vertices;
  for (const Tet& tet : tets) {
    for (const VertexId v : tet) {
      if (std::exchange((*local)[v], 0) == kNoVertex) vertices.push_back(v);
    }
  }
  std::sort(vertices.begin(), vertices.end());
  const auto free = std::stable_partition(vertices.begin(), vertices.end(), [&](std::uint32_t v) {
    return (chunk.mesh.marks[v] & kOnInterface) != 0;
  });
  slice->points = vertices.size();
  slice->shared = static_cast<std::uint64_t>(free - vertices.begin());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) (*local)[vertices[i]] = i;
  corners->assign(tets.begin(), tets.end());
  for (Tet& tet : *corners) {
    for (VertexId& v : tet) v = (*local)[v];
  }
  for (const std::uint32_t v : vertices) (*local)[v] = kNoVertex;
  return vertices;
}

template <class Real>
void PiecesExporter<Real>::store_chunk(const Chunk& chunk) {
  const WorkMesh<Real>& mesh = chunk.mesh;
  const std::size_t begin = first_of_chunk_[chunk.number];
  const std::size_t end = first_of_chunk_[chunk.number + 1];
  keep_lower(chunk);
  Vector<std::uint32_t> local;
  local.assign(mesh.vertex_count(), kNoVertex);
  std::vector<Vector<std::uint32_t>> vertices;
  // The sections that have values of their own; spans into them stay valid when they are moved.
  std::vector<Vector<Tet>> corners(end - begin);
  std::vector<Vector<Vec3<Real>>> positions;
  std::vector<Vector<std::uint32_t>> numbers;
  std::vector<Vector<std::byte>> rows;
  for (std::size_t s = begin; s < end; ++s) {
    vertices.push_back(take_slice(chunk, &stored_.slices[s], &local, &corners[s - begin]));
    positions.push_back(positions_of(mesh, vertices.back()));
    numbers.emplace_back();
    for (const std::uint32_t v : vertices.back()) numbers.back().push_back(chunk.numbers[v]);
  }
  std::vector<PieceRef> pieces;
  const auto add = [&](std::size_t section, auto bytes_of_slice) {
    for (std::size_t s = begin; s < end; ++s) {
      const std::span<const std::byte> bytes = bytes_of_slice(s);
      if (!bytes.empty()) pieces.push_back({stored_.bucket(section, s), bytes});
    }
  };
  add(kPositions, [&](std::size_t s) { return bytes_of(positions[s - begin]); });
  add(kNumbers, [&](std::size_t s) { return bytes_of(numbers[s - begin]); });
  add(kCorners, [&](std::size_t s) { return bytes_of(corners[s - begin]); });
  std::size_t section = kFirstColumn;
  for (const Column& c : mesh.point_columns) {
    add(section++, [&](std::size_t s) {
      return bytes_of(rows.emplace_back(rows_of(c, vertices[s - begin])));
    });
  }
  for (const Column& c : mesh.cell_columns) {
    add(section++, [&](std::size_t s) -> std::span<const std::byte> {
      const Slice& slice = stored_.slices[s];
      return {c.rows.data() + slice.first * c.stride(), slice.tets * c.stride()};
    });
  }
  stored_.store->add(chunk.number, pieces);
}

template <class Real>
void PiecesExporter<Real>::keep_lower(const Chunk& chunk) {
  Vector<std::uint32_t> vertices;
  for (const auto& point : chunks_.used_by_lower(chunk.number)) {
    vertices.push_back(chunk.own[point.number - chunks_.first_point(chunk.number)]);
  }
  LowerPieceRows<Real>& rows = rows_[chunk.number];
  rows.positions = positions_of(chunk.mesh, vertices);
  for (const Column& c : chunk.mesh.point_columns) rows.columns.push_back(rows_of(c, vertices));
}

template <class Real>
void PiecesExporter<Real>::write_piece(std::uint32_t piece, const VtuLayout& layout) {
  const std::size_t begin = first_slice_[piece];
  const std::size_t end = first_slice_[piece + 1];
  PieceWriter<Real> writer(stored_, begin, end, job_.context);
  const auto progress = [&](double done) {
    const double tets = static_cast<double>(written_) + done * static_cast<double>(writer.tets());
    job_.report(kChunksShare +
                (1 - kChunksShare) * tets / static_cast<double>(chunks_.summary().tets));
  };
  writer.write(output_.piece_path(piece), layout, job_.layout, progress);
  written_ += writer.tets();
  const std::size_t columns = job_.layout.point_columns.size() + job_.layout.cell_columns.size();
  for (std::size_t s = begin; s < end; ++s) stored_.forget(s, kFirstColumn + columns);
}

template <class Real>
void PiecesExporter<Real>::write_lower(std::uint32_t piece, VtuLayout layout) {
  const LowerPart<Real>& lower = job_.lower;
  // Each point's id in the input, and its place in the piece.
  Vector<std::pair<VertexId, std::uint32_t>> places;
  Vector<std::int64_t> numbers;
  const auto add = [&](VertexId id, std::uint64_t number) {
    places.push_back({id, static_cast<std::uint32_t>(numbers.size())});
    numbers.push_back(static_cast<std::int64_t>(number));
  };
  for (std::uint32_t c = 0; c < chunks_.chunks(); ++c) {
    for (const auto& point : chunks_.used_by_lower(c)) add(point.id, point.number);
  }
  for (std::size_t i = 0; i < lower.loose_ids.size(); ++i) {
    add(lower.loose_ids[i], chunks_.first_point(chunks_.chunks()) + i);
  }
  std::sort(places.begin(), places.end());
  Vector<std::int64_t> corners;
  for (const VertexId id : lower.cells.connectivity) {
    const auto at = std::lower_bound(places.begin(), places.end(), std::pair(id, std::uint32_t{0}));
    corners.push_back(at->second);
  }

  const CellOrder cells{0, &lower.cells};
  layout.points = numbers.size();
  layout.cells = cells.size();
  layout.corners = corners.size();
  OutputFile file(output_.piece_path(piece), VtuWriter::access(layout.encoding));
  VtuWriter writer(&file, layout);
  for (std::size_t i = 0; i < job_.layout.point_columns.size(); ++i) {
    for (const LowerPieceRows<Real>& rows : rows_) writer.put(rows.columns[i]);
    writer.put(lower.loose_columns[i].rows);
  }
  writer.put(bytes_of(numbers));
  for (const Column& c : lower.columns) writer.put(c.rows);
  for (const LowerPieceRows<Real>& rows : rows_) writer.put(bytes_of(rows.positions));
  writer.put(bytes_of(lower.loose_positions));
  writer.put(bytes_of(corners));
  put_ends_and_types(cells, &writer);
  writer.finish();
  file.commit();
}

}  // namespace

AttributeSet with_global_ids(AttributeSet point_data) {
  std::string name = "GlobalNodeIds";
  while (point_data.find(name) != AttributeSet::npos) name += '_';
  point_data.arrays.push_back({name, ValueType::kInt64, 1, {}, 0});
  const auto before = point_data.active.find("GlobalIds");
  if (before != point_data.active.end()) {
    point_data.active.try_emplace("PedigreeIds", before->second);
  }
  point_data.active["GlobalIds"] = name;
  return point_data;
}

template <class Real>
MeshSummary export_pieces(const ExportJob<Real>& job) {
  return PiecesExporter<Real>(job).run();
}

template MeshSummary export_pieces(const ExportJob<float>&);
template MeshSummary export_pieces(const ExportJob<double>&);

}  // namespace tetfusion
