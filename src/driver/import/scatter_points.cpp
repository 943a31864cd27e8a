#include <algorithm>
#include <span>

#include "base/blocks.h"
#include "base/pool.h"
#include "driver/import/scatter_passes.h"
#include "driver/import/stream_coincident.h"
#include "driver/rounds/windows.h"

namespace tetfusion {

namespace {

template <class Real>
class PointScatterer {
 public:
  PointScatterer(const ScatterJob<Real>& job, PieceStore* to, ScatteredMesh<Real>* out)
      : job_(job),
        to_(to),
        out_(*out),
        windows_(block_count(job.stream.points(), job.point_window.rows)) {}

  void run() {
    if (job_.settings.surfaces_move) find_coincident();
    std::atomic<std::size_t> done{0};
    for_each_block(job_.stream.points(), job_.point_window.rows,
                   [&](std::size_t w, std::size_t begin, std::size_t end) {
                     job_.context.check();
                     const auto memory = job_.wait_for(job_.point_window);
                     scatter_window(static_cast<std::uint32_t>(w), begin, end - begin);
                     job_.context.report("reading", 0.09, 0.12, ++done, windows_.size());
                   });
    to_->seal();
    join_windows();
  }

 private:
  // What is left of one when its points are in their chunks.
  struct Window {
    Box box;
    std::uint64_t valueless = 0, interesting = 0;
    Vector<VertexId> loose_ids;
    Vector<Vec3<Real>> loose_positions;
    std::vector<Column> loose_columns;
  };
  struct Scratch {
    Vector<Vec3<Real>> positions;
    std::vector<Column> columns;
    Vector<double> steering;
    Vector<std::uint8_t> locked, inside, marks;
    Vector<std::uint32_t> last_chunk;
    // A point on the interface goes to several chunks: of each row of a piece its point, counted
    // from the window's first, and its chunk.
    Vector<std::uint32_t> items, chunk_of;
    WindowPieces pieces;
  };

  void find_coincident();
  void scatter_window(std::uint32_t window, std::uint64_t first, std::uint64_t count);
  void read(std::uint64_t first, std::uint64_t count, Scratch* scratch) const;
  void lock(std::uint64_t first, std::uint64_t count, Scratch* scratch, Window* window) const;
  void place(std::uint64_t first, std::uint64_t count, Scratch* scratch, Window* window) const;
  std::size_t find_chunks(VertexId v, std::uint32_t item, Scratch* scratch) const;
  void put(std::uint32_t window, std::uint64_t first, Scratch* scratch) const;
  void join_windows();

  const ScatterJob<Real>& job_;
  PieceStore* to_;
  ScatteredMesh<Real>& out_;
  std::vector<Window> windows_;
  Pool<Scratch> scratch_;
  Vector<bool> coincident_;  // of points; empty: there are none, or nobody asked
};

// Among those that tetrahedra use.
template <class Real>
void PointScatterer<Real>::find_coincident() {
  const auto is_used = [&](std::size_t v) { return job_.table.is_used(static_cast<VertexId>(v)); };
  coincident_.assign(job_.stream.points(), false);
  tetfusion::find_coincident<Real>(
      job_.stream, job_.context, is_used, [](std::uint64_t, std::uint64_t) {},
      [&](VertexId later, VertexId earlier) {
        for (const VertexId v : {later, earlier}) {
          if (!coincident_[v]) ++out_.coincident_points;
          coincident_[v] = true;
        }
      });
  if (out_.coincident_points == 0) coincident_ = {};
}

template <class Real>
void PointScatterer<Real>::scatter_window(std::uint32_t window, std::uint64_t first,
                                          std::uint64_t count) {
  auto scratch = scratch_.borrow();
  read(first, count, &*scratch);
  lock(first, count, &*scratch, &windows_[window]);
  place(first, count, &*scratch, &windows_[window]);
  put(window, first, &*scratch);
}

template <class Real>
void PointScatterer<Real>::read(std::uint64_t first, std::uint64_t count, Scratch* scratch) const {
  scratch->positions.resize(count);
  job_.stream.read_points(first, count, std::as_writable_bytes(std::span(scratch->positions)));
  if (scratch->columns.empty()) scratch->columns = job_.layout.point_columns;
  read_columns(job_.stream, Association::kPoint, job_.carried.point_indices, first, count,
               &scratch->columns);
  scratch->steering.resize(count * job_.steering->width());
  scratch->locked.assign(count, 0);
  job_.steering->read(first, count, scratch->steering.data(), scratch->locked.data());
}

// Those without a value are; what other parts of the mesh and the settings want to be locked, too.
template <class Real>
void PointScatterer<Real>::lock(std::uint64_t first, std::uint64_t count, Scratch* scratch,
                                Window* window) const {
  Vector<std::uint8_t>& locked = scratch->locked;
  window->valueless = count - static_cast<std::uint64_t>(std::ranges::count(locked, 0));
  job_.stream.read_locks(first, count, locked.data());
  if (job_.settings.interest != nullptr) {
    const auto read = [&](std::size_t array, std::span<std::byte> rows) {
      job_.stream.read_rows(Association::kPoint, array, first, count, rows);
    };
    Vector<std::uint8_t>& inside = scratch->inside;
    inside.assign(count, 0);
    job_.settings.interest->template mark<Real>(scratch->positions, read, inside.data());
    for (std::size_t i = 0; i < count; ++i) {
      locked[i] |= inside[i];
      window->interesting += inside[i];
    }
  }
  for (std::size_t i = 0; i < count && !coincident_.empty(); ++i) {
    if (coincident_[first + i]) locked[i] = 1;
  }
}

// Finds each point's chunks and marks, and keeps the loose ones.
template <class Real>
void PointScatterer<Real>::place(std::uint64_t first, std::uint64_t count, Scratch* scratch,
                                 Window* window) const {
  const Vector<VertexId>& carried = out_.lower.vertices;
  auto next_carried =
      std::lower_bound(carried.begin(), carried.end(), static_cast<VertexId>(first));
  window->loose_columns = job_.layout.point_columns;
  scratch->marks.resize(count);
  scratch->last_chunk.resize(count);
  scratch->items.clear();
  scratch->chunk_of.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = static_cast<VertexId>(first + i);
    const std::size_t chunks = find_chunks(v, static_cast<std::uint32_t>(i), scratch);
    const bool is_carried = next_carried != carried.end() && *next_carried == v;
    if (is_carried) ++next_carried;
    const bool is_locked = is_carried || scratch->locked[i] != 0;
    scratch->marks[i] = static_cast<std::uint8_t>(
        (chunks > 1 ? kOnInterface : 0) | (is_locked ? kLocked : 0) | (is_carried ? kCarried : 0));
    if (chunks > 0) {
      const Vec3<Real>& p = scratch->positions[i];
      window->box.add({p.x, p.y, p.z});
    } else if (is_carried) {
      window->loose_ids.push_back(v);
      window->loose_positions.push_back(scratch->positions[i]);
      for (std::size_t c = 0; c < scratch->columns.size(); ++c) {
        append_row(scratch->columns[c], i, &window->loose_columns[c]);
      }
    }
  }
}

// Appends the chunks that are made to those of rows. Returns how many there are, but for the
// excerpt.
template <class Real>
std::size_t PointScatterer<Real>::find_chunks(VertexId v, std::uint32_t item,
                                              Scratch* scratch) const {
  Vector<std::uint32_t>& chunk_of = scratch->chunk_of;
  const std::size_t before = chunk_of.size();
  job_.table.chunks_of(v, &chunk_of);
  // Behind all others.
  const bool in_excerpt = chunk_of.size() > before && chunk_of.back() == job_.chunks;
  const std::size_t chunks = chunk_of.size() - before - (in_excerpt ? 1 : 0);
  scratch->last_chunk[item] = chunks > 0 ? chunk_of[before + chunks - 1] : 0;
  if (job_.settings.sample != nullptr) {
    const auto begin = chunk_of.begin() + static_cast<std::ptrdiff_t>(before);
    const bool is_sampled = std::find(begin, chunk_of.end(), job_.sampled) != chunk_of.end();
    chunk_of.resize(before);
    if (is_sampled) chunk_of.push_back(0);
    scratch->last_chunk[item] = 0;
  }
  scratch->items.insert(scratch->items.end(), chunk_of.size() - before, item);
  return chunks;
}

template <class Real>
void PointScatterer<Real>::put(std::uint32_t window, std::uint64_t first, Scratch* scratch) const {
  const Vector<std::uint32_t>&items = scratch->items, &chunk_of = scratch->chunk_of;
  const auto mark_of = [&](std::size_t row) {
    const std::uint32_t item = items[row];
    unsigned mark = scratch->marks[item];
    if (chunk_of[row] == scratch->last_chunk[item]) mark |= kLast;
    if (chunk_of[row] == job_.chunks) {  // there a point is between chunks if it is not whole
      const bool is_whole = job_.excerpt.has(static_cast<VertexId>(first + item));
      mark = (mark & ~unsigned{kOnInterface}) | (is_whole ? 0 : kOnInterface);
    }
    return static_cast<std::uint8_t>(mark);
  };
  const std::size_t width = job_.steering->width();
  const auto write = [&](std::span<const std::uint32_t> rows, RowWriter* writer) {
    writer->put<VertexId>(rows,
                          [&](std::size_t i) { return static_cast<VertexId>(first + items[i]); });
    writer->put<std::uint8_t>(rows, mark_of);
    writer->put<Vec3<Real>>(rows, [&](std::size_t i) { return scratch->positions[items[i]]; });
    for (std::size_t k = 0; k < width; ++k) {
      writer->put<double>(rows,
                          [&](std::size_t i) { return scratch->steering[items[i] * width + k]; });
    }
    for (const Column& c : scratch->columns) writer->put_rows(c, rows, items);
  };
  scratch->pieces.add(window, chunk_of, job_.made_chunks(), to_, write);
}

template <class Real>
void PointScatterer<Real>::join_windows() {
  LowerPart<Real>& all = out_.lower;
  all.loose_columns = job_.layout.point_columns;
  out_.box = Box();
  for (Window& window : windows_) {
    out_.valueless_points += window.valueless;
    out_.interesting_points += window.interesting;
    append(window.loose_ids, &all.loose_ids);
    append(window.loose_positions, &all.loose_positions);
    append_rows(window.loose_columns, &all.loose_columns);
    out_.box.add(window.box);
    window = {};
  }
}

}  // namespace

template <class Real>
void scatter_points(const ScatterJob<Real>& job, PieceStore* to, ScatteredMesh<Real>* out) {
  PointScatterer<Real>(job, to, out).run();
}

template void scatter_points(const ScatterJob<float>&, PieceStore*, ScatteredMesh<float>*);
template void scatter_points(const ScatterJob<double>&, PieceStore*, ScatteredMesh<double>*);

}  // namespace tetfusion
