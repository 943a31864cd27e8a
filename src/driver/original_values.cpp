// A piece: the number of points, their positions, where surfaces move where to look for them, and
// each column.
#include "driver/original_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "base/serialize.h"
#include "base/tasks.h"
#include "driver/windows.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr const char* kName = "original-values";

// More points of the original than so many for each tetrahedron of the result have nothing to add.
constexpr std::uint64_t kMostPoints = 4;

std::uint64_t sum_of(const std::vector<std::size_t>& strides) {
  return std::accumulate(strides.begin(), strides.end(), std::uint64_t{0});
}

template <class Real>
struct Rows {
  using Strides = std::vector<std::size_t>;  // bytes a row, of the columns
  Rows(std::span<const std::byte> piece, bool have_starts, const Strides& strides) {
    RowReader reader(piece);
    positions = {reader.take<Vec3<Real>>(), reader.items()};
    if (have_starts) starts = {reader.take<Vec3<Real>>(), reader.items()};
    for (const std::size_t s : strides) columns.push_back(reader.take_bytes(reader.items() * s));
  }
  static std::uint64_t bytes_of_row(bool have_starts, const Strides& strides) {
    return (have_starts ? 2 : 1) * sizeof(Vec3<Real>) + sum_of(strides);
  }
  std::span<const Vec3<Real>> positions, starts;
  std::vector<const std::byte*> columns;
};

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
void OriginalValues<Real>::begin() {
  store_.reset();  // its name is free again
  store_ = scratch_->begin(kName);
  chunks_ = 0;
  is_whole_ = false;
}

// A vertex between chunks is its last one's. Where surfaces move, what lies on one may come to lie
// outside, or on the other side of a crack.
template <class Real>
void OriginalValues<Real>::add(std::uint32_t chunk, const WorkMesh<Real>& mesh) {
  ++chunks_;
  std::optional<Starts<Real>> starts;
  if (surfaces_move_) starts.emplace(mesh);
  Vector<std::uint32_t> vertices;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool is_own = sharing_of(mesh.marks[v]) != kShared;
    if (is_own && (!starts || starts->has(v))) vertices.push_back(v);
  }
  if (vertices.empty()) return;
  ByteWriter count;
  count.put(std::uint64_t{vertices.size()});
  Vector<std::byte> piece = count.take();
  RowWriter writer(&piece);
  writer.put<Vec3<Real>>(vertices, [&](std::uint32_t v) { return mesh.positions[v]; });
  if (starts) writer.put<Vec3<Real>>(vertices, [&](std::uint32_t v) { return starts->of(v); });
  for (const std::uint32_t c : columns_) {
    const Column& column = mesh.point_columns[c];
    writer.put_rows(column.rows.data(), column.stride(), vertices);
  }
  const PieceRef ref{chunk, piece};
  store_->add(chunk, {&ref, 1});
}

template <class Real>
void OriginalValues<Real>::end() {
  store_->seal();
  is_whole_ = true;
}

template <class Real>
std::uint32_t OriginalValues<Real>::keep() {
  if (is_whole_ && !is_kept_) scratch_->keep(kName);
  is_kept_ = is_whole_;
  return chunks();
}

template <class Real>
void OriginalValues<Real>::resume(std::uint32_t chunks, Checkpoint* from) {
  if (chunks == 0) return;
  const auto store = from->kept.find(kName);
  if (store == from->kept.end() || store->second == nullptr) {
    throw Error(
        ErrorCode::kIo,
        "the work in the scratch folder lacks the original's values: remove the folder, and "
        "start the run again");
  }
  store_ = std::move(store->second);
  chunks_ = chunks;
  is_whole_ = is_kept_ = true;
}

template <class Real>
FittedValues<Real>::FittedValues(const OriginalValues<Real>& original, const MacroLod<Real>& mesh,
                                 const WorkMesh<Real>& layout, int threads, Scratch* scratch)
    : original_(original), mesh_(mesh) {
  for (const std::uint32_t c : original.columns()) {
    strides_.push_back(layout.point_columns[c].stride());
  }
  if (!mesh.whole) sort_points(threads, scratch);
}

// By the chunk of the mesh that each point is in.
template <class Real>
void FittedValues<Real>::sort_points(int threads, Scratch* scratch) {
  sorted_ = scratch->begin(fmt::format("sorted-values-{}", mesh_.tets));
  Pool<WindowPieces> tools;
  run_tasks(original_.chunks(), threads, [&](std::size_t c, std::size_t) {
    const auto chunk = static_cast<std::uint32_t>(c);
    const auto bucket = original_.store().read(chunk);
    if (bucket->pieces().empty()) return;
    const Rows<Real> rows(bucket->pieces()[0], original_.have_starts(), strides_);
    Vector<std::uint32_t> chunk_of(rows.positions.size());
    for (std::size_t i = 0; i < chunk_of.size(); ++i) {
      chunk_of[i] = mesh_.cut.chunk_of(rows.positions[i]);
    }
    tools.borrow()->add(
        chunk, chunk_of, mesh_.chunks, sorted_.get(), [&](const auto& points, RowWriter* to) {
          to->put<Vec3<Real>>(points, [&](std::uint32_t i) { return rows.positions[i]; });
          if (original_.have_starts()) {
            to->put<Vec3<Real>>(points, [&](std::uint32_t i) { return rows.starts[i]; });
          }
          for (std::size_t k = 0; k < strides_.size(); ++k) {
            to->put_rows(rows.columns[k], strides_[k], points);
          }
        });
  });
  sorted_->seal();
}

template <class Real>
std::uint64_t FittedValues<Real>::points_of(std::uint32_t chunk) const {
  const std::uint64_t bytes = sorted_ ? sorted_->bytes(chunk) : original_.store().bytes();
  return bytes / Rows<Real>::bytes_of_row(original_.have_starts(), strides_);
}

template <class Real>
std::uint64_t FittedValues<Real>::memory(std::uint32_t chunk) const {
  const std::uint64_t tets = mesh_.whole ? mesh_.tets : mesh_.sizes[chunk].tets;
  return fit_memory(points_of(chunk), tets);
}

// All points, or every second, third, ...: however they are cut into pieces.
template <class Real>
void FittedValues<Real>::fit(std::uint32_t chunk, ValueFit<Real>* tool, WorkMesh<Real>* mesh) {
  const double start = wall_seconds();
  tool->begin(mesh, original_.columns());
  const std::uint64_t step = points_of(chunk) / (kMostPoints * mesh->tets.size() + 1) + 1;
  std::uint64_t next = 0;
  for_each_piece(chunk, [&](const Rows<Real>& rows) {
    tool->add({rows.positions, rows.starts}, next, step);
    const std::uint64_t count = rows.positions.size();
    next += next < count ? (count - next + step - 1) / step * step : 0;
    next -= count;
  });
  tool->fit([&](std::size_t column, const auto& use) {
    for_each_piece(chunk, [&](const Rows<Real>& rows) { use(rows.columns[column]); });
  });
  const std::lock_guard lock(seconds_mutex_);
  seconds_ += wall_seconds() - start;
}

// Calls use(rows) with those of each piece that has points of the chunk.
template <class Real>
template <class Use>
void FittedValues<Real>::for_each_piece(std::uint32_t chunk, Use use) const {
  const auto read = [&](const PieceStore& store, std::uint32_t bucket) {
    const auto pieces = store.read(bucket);
    for (const std::span<const std::byte> piece : pieces->pieces()) {
      use(Rows<Real>(piece, original_.have_starts(), strides_));
    }
    pieces->check();
  };
  if (sorted_) {
    read(*sorted_, chunk);
  } else {
    for (std::uint32_t c = 0; c < original_.chunks(); ++c) read(original_.store(), c);
  }
}

std::uint64_t fit_memory(std::uint64_t points, std::uint64_t tets) {
  return ValueFit<double>::memory(std::min(points, kMostPoints * tets), tets);
}

template class OriginalValues<float>;
template class OriginalValues<double>;
template class FittedValues<float>;
template class FittedValues<double>;

}  // namespace tetfusion
