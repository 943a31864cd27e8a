#include "driver/rounds/original_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/resources.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

// More points, or cells, of the original than so many for each tetrahedron of the result have
// nothing to add, or little.
constexpr std::uint64_t kMostPoints = 4;
constexpr std::uint64_t kMostCells = 16;

// The first columns of cells.
enum CellColumn : std::size_t { kCentres, kVolumes, kHashes, kFirstValue };

// Every so-many-th row is enough.
std::uint64_t step_of(std::uint64_t rows, std::uint64_t most, std::uint64_t tets) {
  return rows / (most * tets + 1) + 1;
}

// Calls use(piece, first): its rows first, first + step, ... are those to look at, however all are
// cut into pieces.
template <class Use>
void for_each_step(const SortedRows& rows, std::uint32_t chunk, std::uint64_t step, Use use) {
  std::uint64_t next = 0;
  rows.for_each_piece(chunk, [&](const OriginalPiece& piece) {
    use(piece, next);
    next += next < piece.rows ? (piece.rows - next + step - 1) / step * step : 0;
    next -= piece.rows;
  });
}

// Where to look for the vertices of a mesh when it has become another one: inside at themselves,
// at its surfaces in the middle of the largest tetrahedron that they have.
template <class Real>
class Starts {
 public:
  explicit Starts(const WorkMesh<Real>& mesh)
      : starts_(mesh.positions), volumes_(mesh.vertex_count(), 0) {
    for (VertexId v = 0; v < volumes_.size(); ++v) {
      // Whether a vertex between chunks is on a surface is not yet known.
      if ((mesh.marks[v] & (kOnBoundary | kOnInterface)) == 0) volumes_[v] = kInside;
    }
    for (const Tet& tet : mesh.tets) add(mesh, tet);
  }
  const Vec3<Real>& of(VertexId v) const { return starts_[v]; }
  bool has(VertexId v) const { return volumes_[v] > 0; }

 private:
  static constexpr double kInside = std::numeric_limits<double>::infinity();
  void add(const WorkMesh<Real>& mesh, const Tet& tet) {
    if (std::ranges::all_of(tet, [&](VertexId v) { return volumes_[v] == kInside; })) return;
    const double volume = std::abs(determinant(mesh.positions, tet).value);
    Vec3<double> sum{};
    for (const VertexId v : tet) {
      const Vec3<Real>& p = mesh.positions[v];
      sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
    }
    for (const VertexId v : tet) {
      if (!(volume > volumes_[v])) continue;
      volumes_[v] = volume;
      starts_[v] = {static_cast<Real>(sum.x / 4), static_cast<Real>(sum.y / 4),
                    static_cast<Real>(sum.z / 4)};
    }
  }
  Vector<Vec3<Real>> starts_;
  Vector<double> volumes_;  // of the largest one
};

}  // namespace

template <class Real>
OriginalValues<Real>::OriginalValues(Scratch* scratch, const WorkMesh<Real>& layout,
                                     ColumnsToFit columns, bool surfaces_move)
    : columns_(std::move(columns)), surfaces_move_(surfaces_move) {
  kept_.fractions.assign(columns_.cells.size(), 0);
  if (!columns_.points.empty()) {
    std::vector<std::size_t> strides(surfaces_move ? 2 : 1, sizeof(Vec3<Real>));
    for (const std::uint32_t c : columns_.points) {
      strides.push_back(layout.point_columns[c].stride());
    }
    points_.emplace(scratch, "original-points", std::move(strides));
  }
  if (!columns_.cells.empty()) {
    std::vector<std::size_t> strides{sizeof(Vec3<double>), sizeof(double), sizeof(std::uint64_t)};
    for (const auto* some : {&columns_.cells, &columns_.labels}) {
      for (const std::uint32_t c : *some) strides.push_back(layout.cell_columns[c].stride());
    }
    cells_.emplace(scratch, "original-cells", std::move(strides));
  }
}

template <class Real>
void OriginalValues<Real>::begin() {
  if (points_) points_->begin();
  if (cells_) cells_->begin();
  kept_ = {0, std::vector<std::uint8_t>(columns_.cells.size(), 0)};
  is_whole_ = false;
}

template <class Real>
void OriginalValues<Real>::add(std::uint32_t chunk, const WorkMesh<Real>& mesh) {
  std::atomic_ref(kept_.chunks).fetch_add(1);
  if (points_) add_points(chunk, mesh);
  if (cells_) add_cells(chunk, mesh);
}

// A vertex between chunks is its last one's. Where surfaces move, what lies on one may come to lie
// outside, or on the other side of a crack.
template <class Real>
void OriginalValues<Real>::add_points(std::uint32_t chunk, const WorkMesh<Real>& mesh) {
  std::optional<Starts<Real>> starts;
  if (surfaces_move_) starts.emplace(mesh);
  Vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool is_own = sharing_of(mesh.marks[v]) != kShared;
    if (is_own && (!starts || starts->has(v))) vertices.push_back(v);
  }
  points_->add(chunk, vertices.size(), [&](RowWriter* to) {
    to->put<Vec3<Real>>(vertices, [&](std::uint32_t v) { return mesh.positions[v]; });
    if (starts) to->put<Vec3<Real>>(vertices, [&](std::uint32_t v) { return starts->of(v); });
    for (const std::uint32_t c : columns_.points) {
      const Column& column = mesh.point_columns[c];
      to->put_rows(column.rows.data(), column.stride(), vertices);
    }
  });
}

template <class Real>
void OriginalValues<Real>::add_cells(std::uint32_t chunk, const WorkMesh<Real>& mesh) {
  for (std::size_t c = 0; c < columns_.cells.size(); ++c) {
    const std::atomic_ref known(kept_.fractions[c]);
    if (known.load(std::memory_order_relaxed) != 0) continue;
    const Column& column = mesh.cell_columns[columns_.cells[c]];
    if (has_fractions(column.type, column.rows)) known.store(1, std::memory_order_relaxed);
  }
  Vector<std::uint32_t> tets;
  Vector<double> volumes(mesh.tets.size());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    volumes[t] = volume_of(mesh.positions, mesh.tets[t]);
    if (volumes[t] > 0) tets.push_back(t);
  }
  cells_->add(chunk, tets.size(), [&](RowWriter* to) {
    to->put<Vec3<double>>(tets,
                          [&](std::uint32_t t) { return centre_of(mesh.positions, mesh.tets[t]); });
    to->put<double>(tets, [&](std::uint32_t t) { return volumes[t]; });
    to->put<std::uint64_t>(
        tets, [&](std::uint32_t t) { return corners_hash(mesh.positions, mesh.tets[t]); });
    for (const auto* some : {&columns_.cells, &columns_.labels}) {
      for (const std::uint32_t c : *some) {
        const Column& column = mesh.cell_columns[c];
        to->put_rows(column.rows.data(), column.stride(), tets);
      }
    }
  });
}

template <class Real>
void OriginalValues<Real>::end() {
  if (points_) points_->end();
  if (cells_) cells_->end();
  is_whole_ = true;
}

template <class Real>
KeptValues OriginalValues<Real>::keep() {
  if (!is_whole_) return {};
  if (points_) points_->keep();
  if (cells_) cells_->keep();
  return kept_;
}

template <class Real>
void OriginalValues<Real>::resume(const KeptValues& kept, Checkpoint* from) {
  if (kept.chunks == 0) return;
  if (points_) points_->resume(from);
  if (cells_) cells_->resume(from);
  kept_ = kept;
  is_whole_ = true;
}

template <class Real>
std::vector<std::uint32_t> OriginalValues<Real>::columns_to_average() const {
  std::vector<std::uint32_t> some;
  for (std::size_t c = 0; c < columns_.cells.size(); ++c) {
    if (kept_.fractions[c] != 0) some.push_back(columns_.cells[c]);
  }
  return some;
}

// Sorted by the chunk of the mesh that each point, and each centre, is in.
template <class Real>
FittedValues<Real>::FittedValues(const OriginalValues<Real>& original, const MacroLod<Real>& mesh,
                                 MoveLimits moves, int threads, Scratch* scratch)
    : original_(original), mesh_(mesh), moves_(std::move(moves)) {
  const auto take = [&](const OriginalRows* rows, const char* name, auto position) {
    std::optional<SortedRows> sorted;
    if (rows == nullptr) return sorted;
    sorted.emplace(*rows, original.chunks());
    if (mesh.whole) return sorted;
    sorted->sort(fmt::format("sorted-{}-{}", name, mesh.tets), mesh.chunks, threads, scratch,
                 [&](const OriginalPiece& piece) {
                   const auto positions = piece.column<decltype(position)>(0);
                   Vector<std::uint32_t> chunks(positions.size());
                   for (std::size_t i = 0; i < chunks.size(); ++i) {
                     chunks[i] = mesh.cut.chunk_of(positions[i]);
                   }
                   return chunks;
                 });
    return sorted;
  };
  points_ = take(original.points(), "points", Vec3<Real>());
  if (!original.columns_to_average().empty()) {
    cells_ = take(original.cells(), "cells", Vec3<double>());
  }
}

template <class Real>
std::uint64_t FittedValues<Real>::memory(std::uint32_t chunk) const {
  const std::uint64_t tets = mesh_.whole ? mesh_.tets : mesh_.sizes[chunk].tets;
  return fit_memory(points_ ? points_->count(chunk) : 0, cells_ ? cells_->count(chunk) : 0, tets);
}

template <class Real>
void FittedValues<Real>::fit(std::uint32_t chunk, FitTools<Real>* tools, WorkMesh<Real>* mesh) {
  if (mesh->tets.empty()) return;
  const double start = wall_seconds();
  tools->walk.begin(*mesh);
  tools->walk.leave_out_overlaps();
  if (points_) fit_points(chunk, tools, mesh);
  if (cells_) average_cells(chunk, tools, mesh);
  const std::lock_guard lock(seconds_mutex_);
  seconds_ += wall_seconds() - start;
}

template <class Real>
void FittedValues<Real>::fit_points(std::uint32_t chunk, FitTools<Real>* tools,
                                    WorkMesh<Real>* mesh) const {
  const bool have_starts = original_.have_starts();
  const std::size_t first_value = have_starts ? 2 : 1;
  const std::uint64_t step = step_of(points_->count(chunk), kMostPoints, mesh->tets.size());
  const auto points_of = [&](const OriginalPiece& piece) {
    PointsToFit<Real> points{piece.column<Vec3<Real>>(0), {}};
    if (have_starts) points.starts = piece.column<Vec3<Real>>(1);
    return points;
  };
  const auto read = [&](std::size_t column, const auto& use) {
    points_->for_each_piece(
        chunk, [&](const OriginalPiece& piece) { use(piece.columns[first_value + column]); });
  };
  tools->points.begin(mesh, original_.columns().points, &tools->walk);
  for_each_step(*points_, chunk, step, [&](const OriginalPiece& piece, std::uint64_t first) {
    tools->points.add(points_of(piece), first, step);
  });
  tools->points.move(moves_, read, [&](const auto& take) {
    points_->for_each_piece(chunk, [&](const OriginalPiece& piece) { take(points_of(piece)); });
  });
  tools->points.fit(read);
}

// A tetrahedron whose centre lies in another chunk keeps what it has: if it is one of the
// original's itself, that one was sorted to there, and nothing tells here; where the mesh overlaps
// itself, it might get another cell's values.
template <class Real>
void FittedValues<Real>::average_cells(std::uint32_t chunk, FitTools<Real>* tools,
                                       WorkMesh<Real>* mesh) const {
  const ColumnsToFit& all = original_.columns();
  const std::vector<std::uint32_t> columns = original_.columns_to_average();
  const std::uint64_t step = step_of(cells_->count(chunk), kMostCells, mesh->tets.size());
  tools->cells.begin(mesh, columns, all.labels, &tools->walk);
  if (!mesh_.whole) {
    for (TetId t = 0; t < mesh->tets.size(); ++t) {
      const Vec3<double> centre = centre_of(mesh->positions, mesh->tets[t]);
      if (mesh_.cut.chunk_of(centre) != chunk) tools->cells.keep(t);
    }
  }
  for_each_step(*cells_, chunk, step, [&](const OriginalPiece& piece, std::uint64_t first) {
    const auto labels =
        piece.columns.begin() + static_cast<std::ptrdiff_t>(kFirstValue + all.cells.size());
    tools->cells.add({piece.column<Vec3<double>>(kCentres),
                      piece.column<double>(kVolumes),
                      piece.column<std::uint64_t>(kHashes),
                      {labels, piece.columns.end()}},
                     first, step);
  });
  tools->cells.average([&](std::size_t column, const auto& use) {
    const auto at = std::ranges::find(all.cells, columns[column]) - all.cells.begin();
    cells_->for_each_piece(chunk, [&](const OriginalPiece& piece) {
      use(piece.column<double>(kVolumes).data(),
          piece.columns[kFirstValue + static_cast<std::size_t>(at)]);
    });
  });
}

std::uint64_t fit_memory(std::uint64_t points, std::uint64_t cells, std::uint64_t tets) {
  return TetWalk<double>::memory(tets) +
         ValueFit<double>::memory(std::min(points, kMostPoints * tets), tets) +
         (cells > 0 ? CellMeans<double>::memory(std::min(cells, kMostCells * tets), tets) : 0);
}

template class OriginalValues<float>;
template class OriginalValues<double>;
template class FittedValues<float>;
template class FittedValues<double>;

}  // namespace tetfusion
