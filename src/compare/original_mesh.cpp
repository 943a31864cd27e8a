#include "compare/original_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "base/error.h"
#include "compare/region_labels.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kMostRows = std::uint64_t{1} << 18, kLeastRows = std::uint64_t{1} << 12;
constexpr std::uint64_t kWindowBytes = std::uint64_t{12} << 20;  // where rows are wide
constexpr std::size_t kTetsPerBlock = 8192;
constexpr std::uint64_t kMostInRun = std::uint64_t{1} << 14;  // points that a thread reads at once

// As they are in memory, and as they are read, one array after the other.
std::uint64_t bytes_of_row(const FieldSet& fields) {
  std::uint64_t widest = 0;
  for (const Field& field : fields.fields) widest = std::max(widest, field.info.row_bytes());
  return fields.width * sizeof(double) + widest;
}

std::uint64_t rows_in_window(const FieldSet& points, const FieldSet& cells) {
  const std::uint64_t row = std::max(bytes_of_row(points), bytes_of_row(cells));
  std::uint64_t rows = kMostRows;
  while (rows > kLeastRows && rows * row > kWindowBytes) rows /= 2;
  return rows;
}

struct Run {
  std::uint64_t first, count;
};

// Of a set's points in [first, first + count), in steps of 64, where none is left out that is in
// the set. `first` is a multiple of 64.
std::vector<Run> runs_of(const PointSet& set, std::uint64_t first, std::uint64_t count,
                         std::uint64_t most) {
  std::vector<Run> runs;
  const std::uint64_t end = first + count;
  constexpr std::uint64_t kGap = 4096;  // cheaper to read than to begin anew
  for (std::uint64_t at = first; at < end; at += 64) {
    if (!set.any_in_word(at / 64)) continue;
    const std::uint64_t after = std::min(at + 64, end);
    if (runs.empty() || at - (runs.back().first + runs.back().count) > kGap ||
        after - runs.back().first > most) {
      runs.push_back({at, after - at});
    } else {
      runs.back().count = after - runs.back().first;
    }
  }
  return runs;
}

template <class Real>
void spread_points(const Vector<std::byte>& bytes, const Vector<std::uint64_t>& rows, Point* out) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::array<Real, 3> p;
    std::memcpy(p.data(), bytes.data() + rows[i] * sizeof p, sizeof p);
    out[i] = {p[0], p[1], p[2]};
  }
}

}  // namespace

void PointSet::add(const Vector<Tet>& tets) {
  for_each_block(tets.size(), kTetsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      for (const VertexId v : tets[t]) {
        const std::uint64_t bit = std::uint64_t{1} << v % 64;
        const std::atomic_ref word(words_[v / 64]);
        if ((word.load(std::memory_order_relaxed) & bit) == 0) {
          word.fetch_or(bit, std::memory_order_relaxed);
        }
      }
    }
  });
}

void PointSet::number() {
  before_.resize(words_.size());
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < words_.size(); ++w) {
    before_[w] = count;
    count += static_cast<std::uint32_t>(std::popcount(words_[w]));
  }
}

std::uint64_t PointSet::id_of(std::uint64_t number) const {
  // The last word with no more than `number` before it has the id.
  const auto after = std::upper_bound(before_.begin(), before_.end(), number);
  const auto w = static_cast<std::size_t>(after - before_.begin()) - 1;
  std::uint64_t word = words_[w];
  for (std::uint64_t i = before_[w]; i < number; ++i) word &= word - 1;
  return 64 * w + static_cast<std::uint64_t>(std::countr_zero(word));
}

OriginalMesh::OriginalMesh(MeshSource* source, const FieldSet& point_fields,
                           const FieldSet& cell_fields)
    : source_(source),
      point_fields_(point_fields),
      cell_fields_(cell_fields),
      window_(rows_in_window(point_fields, cell_fields)),
      stream_(open_stream(source)),
      used_(stream_->points()) {}

void OriginalMesh::choose_bases(Association association, FieldSet* fields) const {
  const auto is_long = [](const Field& field) {
    const ValueType type = field.info.type;
    return field.integer && (type == ValueType::kInt64 || type == ValueType::kUInt64);
  };
  if (std::ranges::none_of(fields->fields, is_long)) return;
  const std::optional<std::uint64_t> row = first_row_in_use(association);
  for (Field& field : fields->fields) {
    if (!row || !is_long(field)) continue;
    Vector<std::byte> tuple(field.info.row_bytes());
    stream_->read_rows(association, field.original, *row, 1, tuple);
    std::uint64_t bits = 0;
    std::memcpy(&bits, tuple.data(), sizeof bits);
    field.base = field.info.type == ValueType::kInt64 ? WideInteger{static_cast<std::int64_t>(bits)}
                                                      : WideInteger{bits};
  }
}

// That of the first tetrahedron, or of a corner of it.
std::optional<std::uint64_t> OriginalMesh::first_row_in_use(Association association) const {
  constexpr std::uint64_t kFew = 4096;
  CellWindow window;
  for (std::uint64_t first = 0; first < stream_->cells(); first += kFew) {
    stream_->read_cells(first, std::min(kFew, stream_->cells() - first), &window);
    if (window.tets.empty()) continue;
    if (association == Association::kPoint) return window.tets[0][0];
    return window.tet_rows.empty() ? first : window.tet_rows[0];
  }
  return std::nullopt;
}

void OriginalMesh::survey(std::size_t most_sides, const RunContext& context) {
  const ReadCells read = [&](const auto& take) {
    const bool first_time = tets_ == 0;
    std::uint64_t tets = 0;
    read_cells([&](std::uint64_t, const CellWindow& window, double) {
      context.check();
      if (first_time) used_.add(window.tets);
      take({tets, window.tets});
      tets += window.tets.size();
    });
    tets_ = tets;
  };
  boundary_ = triangles_of(find_single_sides(stream_->points(), most_sides, read));
  used_.number();
  if (boundary_.triangles.empty()) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: the mesh has no boundary: its cells are doubled, or have no volume; see "
                    "'tetfusion check {}'",
                    source_->description().path, source_->description().path));
  }
}

void OriginalMesh::match_parts(std::span<const PartFigures> simplified, const RunContext& context) {
  if (simplified.empty()) return;
  PartFinder finder(stream_->points());
  read_cells([&](std::uint64_t, const CellWindow& window, double) {
    context.check();
    finder.add(window.tets);
  });
  std::uint32_t count = 0;
  Vector<std::uint32_t> own = finder.parts([&](std::uint64_t p) { return used_.has(p); }, &count);
  if (count != simplified.size()) return;
  std::vector<PartFigures> figures(count);
  PointSet set(stream_->points());
  OriginalCells cells;
  read_cells([&](std::uint64_t, const CellWindow& window, double) {
    context.check();
    gather_corners(window, {}, &set, &cells);
    for (std::size_t t = 0; t < cells.tets.size(); ++t) {
      Corners corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = cells.points.points[cells.tets[t][i]];
      figures[own[window.tets[t][0]]].add(corners);
    }
  });
  const Vector<std::uint32_t> match = find_counterparts(figures, simplified);
  for (std::uint32_t& part : own) part = part == kAnyPart ? kAnyPart : match[part];
  part_of_ = std::move(own);
  for (const VertexId v : boundary_.point_ids) boundary_.parts.push_back(part_of_[v]);
}

TriangleSet OriginalMesh::find_interfaces(const std::vector<std::size_t>& cell_arrays,
                                          std::size_t most_sides, const RunContext& context) const {
  RegionLabels labels(source_->description(), cell_arrays);
  const ReadCells read = [&](const auto& take) {
    read_cells([&](std::uint64_t first, const CellWindow& window, double) {
      context.check();
      const std::uint64_t count = std::min(window_, stream_->cells() - first);
      take({first, window.tets, labels.read(*stream_, first, count, window)});
    });
  };
  return triangles_of(
      match_faces(stream_->points(), most_sides, read, [](std::span<const CellSide> face) {
        return std::any_of(face.begin(), face.end(),
                           [&](const CellSide& s) { return s.side / 4 != face.front().side / 4; });
      }));
}

TriangleSet OriginalMesh::triangles_of(const Vector<CellSide>& sides) const {
  TriangleSet result;
  PointSet set(stream_->points());
  for (const CellSide& s : sides) {
    for (const VertexId v : {s.low, s.middle, s.high}) set.add(v);
  }
  set.number();
  OriginalPoints points;
  gather(set, 0, stream_->points(), {}, &points);
  result.points = std::move(points.points);
  result.point_ids = std::move(points.ids);
  for (const CellSide& s : sides) {
    const auto number = [&](VertexId v) { return static_cast<std::uint32_t>(set.number_of(v)); };
    result.triangles.push_back({number(s.low), number(s.middle), number(s.high)});
  }
  order_triangles(&result);
  return result;
}

void OriginalMesh::read_cells(
    const std::function<void(std::uint64_t, const CellWindow&, double)>& take) const {
  const std::uint64_t cells = stream_->cells();
  CellWindow window;
  for (std::uint64_t first = 0; first < cells; first += window_) {
    const std::uint64_t count = std::min(window_, cells - first);
    stream_->read_cells(first, count, &window);
    take(first, window, static_cast<double>(first + count) / static_cast<double>(cells));
  }
}

void OriginalMesh::for_each_points(
    const std::function<void(const OriginalPoints&, double)>& take) const {
  const std::uint64_t points = stream_->points();
  OriginalPoints window;
  for (std::uint64_t first = 0; first < points; first += window_) {
    const std::uint64_t count = std::min(window_, points - first);
    gather(used_, first, count, point_fields_, &window);
    take(window, static_cast<double>(first + count) / static_cast<double>(points));
  }
}

void OriginalMesh::for_each_cells(
    const std::function<void(const OriginalCells&, double)>& take) const {
  PointSet set(stream_->points());
  OriginalCells cells;
  read_cells([&](std::uint64_t first, const CellWindow& window, double share) {
    gather_corners(window, point_fields_, &set, &cells);
    cells.first_row = first;
    cells.tet_rows = window.tet_rows;
    const std::uint64_t count = std::min(window_, stream_->cells() - first);
    gather_cell_rows(first, count, window, &cells.cell_rows);
    take(cells, share);
  });
}

// The tetrahedra and the points that they use, which `set` becomes.
void OriginalMesh::gather_corners(const CellWindow& window, const FieldSet& fields, PointSet* set,
                                  OriginalCells* out) const {
  set->clear();
  set->add(window.tets);
  set->number();
  gather(*set, 0, stream_->points(), fields, &out->points);
  out->tets.resize(window.tets.size());
  for_each_block(window.tets.size(), kTetsPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t t = begin; t < end; ++t) {
                     for (std::size_t i = 0; i < 4; ++i) {
                       out->tets[t][i] = static_cast<VertexId>(set->number_of(window.tets[t][i]));
                     }
                   }
                 });
}

void OriginalMesh::gather(const PointSet& set, std::uint64_t first, std::uint64_t count,
                          const FieldSet& fields, OriginalPoints* out) const {
  const std::uint64_t base = set.number_of(first);
  const std::uint64_t size = set.number_of(first + count) - base;
  out->ids.resize(size);
  out->points.resize(size);
  out->rows.resize(size * fields.width);
  const std::vector<Run> runs = runs_of(set, first, count, std::min(window_, kMostInRun));
  for_each_block(runs.size(), 1, [&](std::size_t r, std::size_t, std::size_t) {
    gather_run(set, runs[r].first, runs[r].count, fields, out, base);
  });
  out->parts.clear();
  if (part_of_.empty()) return;
  for (const VertexId v : out->ids) out->parts.push_back(part_of_[v]);
}

void OriginalMesh::gather_run(const PointSet& set, std::uint64_t first, std::uint64_t count,
                              const FieldSet& fields, OriginalPoints* out,
                              std::uint64_t base) const {
  Vector<std::uint64_t> rows;
  for (std::uint64_t id = first; id < first + count; ++id) {
    if (set.has(id)) rows.push_back(id - first);
  }
  const std::uint64_t to = set.number_of(first) - base;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out->ids[to + i] = static_cast<VertexId>(first + rows[i]);
  }
  const ValueType type = source_->description().point_type;
  Vector<std::byte> bytes(count * 3 * size_of(type));
  stream_->read_points(first, count, bytes);
  if (type == ValueType::kFloat32) {
    spread_points<float>(bytes, rows, out->points.data() + to);
  } else {
    spread_points<double>(bytes, rows, out->points.data() + to);
  }
  for (const Field& field : fields.fields) {
    bytes.resize(count * field.info.row_bytes());
    stream_->read_rows(Association::kPoint, field.original, first, count, bytes);
    spread_values(field.info, bytes,
                  {fields.width, field.offset, rows.size(), rows,
                   out->rows.data() + to * fields.width, field.base, field.factor()});
  }
  fill_lengths(fields, rows.size(), out->rows.data() + to * fields.width);
}

void OriginalMesh::gather_cell_rows(std::uint64_t first, std::uint64_t count,
                                    const CellWindow& window, Vector<double>* out) const {
  const FieldSet& fields = cell_fields_;
  out->resize(window.tets.size() * fields.width);
  Vector<std::uint64_t> rows(window.tet_rows.size());
  for (std::size_t t = 0; t < rows.size(); ++t) rows[t] = window.tet_rows[t] - first;
  Vector<std::byte> bytes;
  for (const Field& field : fields.fields) {
    bytes.resize(count * field.info.row_bytes());
    stream_->read_rows(Association::kCell, field.original, first, count, bytes);
    spread_values(field.info, bytes,
                  {fields.width, field.offset, window.tets.size(), rows, out->data(), field.base,
                   field.factor()});
  }
}

}  // namespace tetfusion
