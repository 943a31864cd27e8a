#include "driver/scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>

#include "driver/stream_coincident.h"
#include "driver/windows.h"
#include "mesh/blocks.h"
#include "partition/curve_excerpt.h"
#include "partition/vertex_chunks.h"

namespace tetfusion {

namespace {

// What reading a window and sorting it takes.
constexpr std::uint64_t kWindowMemory = std::uint64_t{48} << 20;

// A point of an excerpt takes about ten tetrahedra, and two points beside it: so that it is no
// larger than a chunk.
constexpr std::uint64_t kTetsAPoint = 16;

// Where the layout has a column more than the input has arrays, it is for these.
void number_cells(std::uint64_t first, std::uint64_t count, Column* column) {
  column->resize(count);
  auto* numbers = reinterpret_cast<TetId*>(column->rows.data());
  std::iota(numbers, numbers + count, static_cast<TetId>(first));
}

template <class Real>
class Scatterer {
 public:
  Scatterer(const MeshStream& stream, const CarriedArrays& carried, const Steering& steering,
            const ScatterSettings& settings, const WorkMesh<Real>& layout,
            const RunContext& context, MemoryBudget* budget)
      : stream_(stream),
        carried_(carried),
        steering_(steering),
        settings_(settings),
        layout_(layout),
        context_(context),
        budget_(budget),
        table_(stream.points()) {}

  ScatteredMesh<Real> run(PhaseClock* clock, Scratch* scratch) {
    const std::uint64_t chunks = block_count(stream_.cells(), settings_.chunk_tets);
    if (chunks > VertexChunks::kMaxChunks) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("--chunk-tets {} would cut this mesh into {} chunks; at most {} are "
                              "possible: give at least {}",
                              settings_.chunk_tets, chunks, VertexChunks::kMaxChunks,
                              block_count(stream_.cells(), VertexChunks::kMaxChunks)));
    }
    out_.all_chunks = chunks_ = static_cast<std::uint32_t>(std::max<std::uint64_t>(chunks, 1));
    out_.chunks = settings_.sample != nullptr ? 1 : chunks_;
    out_.has_excerpt = settings_.excerpt && chunks_ > 1;
    clock->begin("locate");
    find_homes();
    clock->begin("scatter cells");
    out_.tets = scratch->begin("tets");
    scatter_tets(out_.tets.get());
    clock->begin("scatter points");
    out_.points = scratch->begin("points");
    scatter_points(out_.points.get());
    out_.tet_count = tet_count_;
    for (const std::uint64_t ghosts : ghosts_) out_.ghost_cells += ghosts;
    return std::move(out_);
  }

 private:
  void find_homes();
  Vector<Vec3<Real>> read_positions(std::uint64_t first, std::uint64_t count) const;
  // All, and the excerpt, or the one in the middle as number 0.
  std::uint32_t made_chunks() const {
    return settings_.sample != nullptr ? 1 : chunks_ + (out_.has_excerpt ? 1 : 0);
  }
  bool is_made(std::uint32_t chunk) const {
    return settings_.sample == nullptr || chunk == chunks_ / 2;
  }
  void scatter_tets(PieceStore* to);
  void scatter_window(std::size_t window, std::uint64_t first, std::uint64_t count, PieceStore* to);
  void take_lower(std::size_t window, std::uint64_t first, const CellWindow& cells,
                  const std::vector<Column>& columns);
  void keep_sampled(CellWindow* cells, Vector<std::uint32_t>* chunk_of);
  void add_to_excerpt(CellWindow* cells, Vector<std::uint32_t>* chunk_of);
  void set_in_excerpt(VertexId v) {
    std::atomic_ref(in_excerpt_[v / 64])
        .fetch_or(std::uint64_t{1} << v % 64, std::memory_order_relaxed);
  }
  // Has the excerpt all tetrahedra of the point?
  bool is_in_excerpt(VertexId v) const { return (in_excerpt_[v / 64] >> v % 64 & 1) != 0; }
  // There a point is between chunks if the excerpt lacks some of its tetrahedra.
  std::uint8_t marks_in_excerpt(std::uint64_t v, std::uint8_t marks) const {
    const bool is_whole = is_in_excerpt(static_cast<VertexId>(v));
    return static_cast<std::uint8_t>((marks & ~kOnInterface) | (is_whole ? 0 : kOnInterface));
  }
  void join_lower();
  void scatter_points(PieceStore* to);
  void find_coincident();
  void keep_sampled(std::size_t begin, Vector<std::uint32_t>* chunk_of) const;
  void scatter_point_window(std::size_t window, std::uint64_t first, std::uint64_t count,
                            PieceStore* to);
  void note_values(std::size_t window, const double* values);
  void join_boxes();

  const MeshStream& stream_;
  const CarriedArrays& carried_;
  const Steering& steering_;
  const ScatterSettings& settings_;
  const WorkMesh<Real>& layout_;
  const RunContext& context_;
  MemoryBudget* budget_;
  std::uint32_t chunks_ = 1;
  VertexChunks table_;
  ScatteredMesh<Real> out_;

  // Of the windows, by number: what has no place in chunks.
  struct LowerWindow {
    LowerCells cells;
    std::vector<Column> columns;
  };
  struct LooseWindow {
    Vector<VertexId> ids;
    Vector<Vec3<Real>> positions;
    std::vector<Column> columns;
  };
  struct CellScratch {
    CellWindow cells;
    std::vector<Column> columns;
    Vector<std::uint32_t> chunk_of;
    WindowPieces pieces;
  };
  struct PointScratch {
    Vector<Vec3<Real>> positions;
    std::vector<Column> columns;
    Vector<double> steering;
    Vector<std::uint32_t> items, chunk_of;
    WindowPieces pieces;
  };
  Pool<CellScratch> cell_scratch_;
  Pool<PointScratch> point_scratch_;
  std::vector<LowerWindow> lower_;
  std::vector<LooseWindow> loose_;
  std::vector<SteeringBox> boxes_;
  std::vector<std::uint64_t> ghosts_;
  std::atomic<std::uint64_t> tet_count_{0};
  Vector<bool> coincident_;           // of points; empty: there are none, or nobody asked
  Vector<std::uint64_t> in_excerpt_;  // a bit a point; empty: there is no excerpt
};

template <class Real>
Vector<Vec3<Real>> Scatterer<Real>::read_positions(std::uint64_t first, std::uint64_t count) const {
  Vector<Vec3<Real>> positions(count);
  stream_.read_points(first, count, std::as_writable_bytes(std::span(positions)));
  return positions;
}

// The first cut: a point's chunk by its place on the curve.
template <class Real>
void Scatterer<Real>::find_homes() {
  const std::uint64_t points = stream_.points();
  const std::uint64_t step =
      std::max<std::uint64_t>(1, points / (kSamplesPerChunk * std::uint64_t{chunks_}));
  struct Window {
    Box box;
    Vector<Vec3<Real>> samples;
  };
  std::vector<Window> windows(block_count(points, settings_.point_window));
  for_each_block(points, settings_.point_window,
                 [&](std::size_t w, std::size_t begin, std::size_t end) {
                   context_.check();
                   const Vector<Vec3<Real>> positions = read_positions(begin, end - begin);
                   for (std::size_t i = 0; i < positions.size(); ++i) {
                     const Vec3<Real>& p = positions[i];
                     windows[w].box.add({p.x, p.y, p.z});
                     if ((begin + i) % step == 0) windows[w].samples.push_back(p);
                   }
                 });
  for (const Window& window : windows) out_.box.add(window.box);
  if (chunks_ == 1) return;
  const ShiftedCurve curve(out_.box, 0);
  Vector<std::uint64_t> keys;
  for (const Window& window : windows) {
    out_.samples.insert(out_.samples.end(), window.samples.begin(), window.samples.end());
    for (const Vec3<Real>& p : window.samples) keys.push_back(curve.key(p));
  }
  const CurveExcerpt excerpt = out_.has_excerpt
                                   ? CurveExcerpt(points, settings_.chunk_tets / kTetsAPoint, keys)
                                   : CurveExcerpt();
  if (out_.has_excerpt) in_excerpt_.assign(points / 64 + 1, 0);
  const CurveCut cut(curve, chunks_, std::move(keys));
  for_each_block(points, settings_.point_window,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   context_.check();
                   const Vector<Vec3<Real>> positions = read_positions(begin, end - begin);
                   for (std::size_t i = begin; i < end; ++i) {
                     const auto v = static_cast<VertexId>(i);
                     const std::uint64_t key = curve.key(positions[i - begin]);
                     table_.set_home(v, cut.chunk_of_key(key));
                     if (excerpt.has(key)) set_in_excerpt(v);
                   }
                 });
}

template <class Real>
void Scatterer<Real>::scatter_tets(PieceStore* to) {
  const std::uint64_t cells = stream_.cells();
  const std::size_t windows = block_count(cells, settings_.cell_window);
  lower_.resize(windows);
  ghosts_.assign(windows, 0);
  std::atomic<std::size_t> done{0};
  for_each_block(cells, settings_.cell_window,
                 [&](std::size_t w, std::size_t begin, std::size_t end) {
                   context_.check();
                   const auto memory = budget_->wait_for(kWindowMemory, "a window of the input");
                   scatter_window(w, begin, end - begin, to);
                   context_.report("reading", 0.02, 0.09, ++done, windows);
                 });
  to->seal();
  cell_scratch_.clear();
  table_.finish();
  join_lower();
}

template <class Real>
void Scatterer<Real>::scatter_window(std::size_t window, std::uint64_t first, std::uint64_t count,
                                     PieceStore* to) {
  auto scratch = cell_scratch_.borrow();
  CellWindow& cells = scratch->cells;
  stream_.read_cells(first, count, &cells);
  std::vector<Column>& columns = scratch->columns;
  if (columns.empty()) columns = layout_.cell_columns;
  read_columns(stream_, Association::kCell, carried_.cell_indices, first, count, &columns);
  if (columns.size() > carried_.cell_indices.size()) number_cells(first, count, &columns.back());
  ghosts_[window] = cells.ghost_cells;
  tet_count_ += cells.tets.size();
  take_lower(window, first, cells, columns);

  Vector<std::uint32_t>& chunk_of = scratch->chunk_of;
  chunk_of.resize(cells.tets.size());
  {
    VertexChunks::Notes notes(&table_);
    for (std::size_t t = 0; t < cells.tets.size(); ++t) {
      chunk_of[t] = notes.add(cells.tets[t]);
    }
  }
  for (std::uint64_t& row : cells.tet_rows) row -= first;
  if (settings_.sample != nullptr) keep_sampled(&cells, &chunk_of);
  if (out_.has_excerpt) add_to_excerpt(&cells, &chunk_of);
  scratch->pieces.add(static_cast<std::uint32_t>(window), chunk_of, made_chunks(), to,
                      [&](std::span<const std::uint32_t> items, RowWriter* writer) {
                        writer->put<Tet>(items, [&](std::size_t t) { return cells.tets[t]; });
                        for (const Column& c : columns) writer->put_rows(c, items, cells.tet_rows);
                      });
}

// Rows count from the window's first.
template <class Real>
void Scatterer<Real>::keep_sampled(CellWindow* cells, Vector<std::uint32_t>* chunk_of) {
  settings_.sample->add(cells->tets);
  const bool all_rows = cells->tet_rows.empty();
  if (all_rows) cells->tet_rows.resize(cells->tets.size());
  std::size_t kept = 0;
  for (std::size_t t = 0; t < cells->tets.size(); ++t) {
    if (!is_made((*chunk_of)[t])) continue;
    cells->tets[kept] = cells->tets[t];
    cells->tet_rows[kept++] = all_rows ? t : cells->tet_rows[t];
  }
  cells->tets.resize(kept);
  cells->tet_rows.resize(kept);
  chunk_of->assign(kept, 0);
}

// Copies of the tetrahedra that have a point of it.
template <class Real>
void Scatterer<Real>::add_to_excerpt(CellWindow* cells, Vector<std::uint32_t>* chunk_of) {
  VertexChunks::Notes notes(&table_);
  Vector<std::uint64_t>& rows = cells->tet_rows;
  const bool has_columns = !layout_.cell_columns.empty();
  const std::size_t count = cells->tets.size();
  for (std::size_t t = 0; t < count; ++t) {
    const Tet tet = cells->tets[t];
    if (std::ranges::none_of(tet, [&](VertexId v) { return is_in_excerpt(v); })) continue;
    if (has_columns && rows.empty()) {
      rows.resize(count);
      std::iota(rows.begin(), rows.end(), std::uint64_t{0});
    }
    if (has_columns) rows.push_back(rows[t]);
    cells->tets.push_back(tet);
    chunk_of->push_back(chunks_);
    for (const VertexId v : tet) notes.add(v, chunks_);
  }
}

template <class Real>
void Scatterer<Real>::take_lower(std::size_t window, std::uint64_t first, const CellWindow& cells,
                                 const std::vector<Column>& columns) {
  if (cells.lower.size() == 0) return;
  LowerWindow& lower = lower_[window];
  lower.cells = cells.lower;
  lower.columns = layout_.cell_columns;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (const std::uint64_t row : cells.lower_rows) {
      append_row(columns[c], row - first, &lower.columns[c]);
    }
  }
}

template <class Real>
void Scatterer<Real>::join_lower() {
  LowerPart<Real>& all = out_.lower;
  all.columns = layout_.cell_columns;
  for (LowerWindow& window : lower_) {
    const LowerCells& cells = window.cells;
    if (cells.size() == 0) continue;
    if (all.cells.size() == 0) all.cells.offsets.push_back(0);
    const std::uint64_t begin = all.cells.connectivity.size();
    all.cells.types.insert(all.cells.types.end(), cells.types.begin(), cells.types.end());
    for (std::size_t i = 1; i < cells.offsets.size(); ++i) {
      all.cells.offsets.push_back(begin + cells.offsets[i]);
    }
    all.cells.connectivity.insert(all.cells.connectivity.end(), cells.connectivity.begin(),
                                  cells.connectivity.end());
    for (std::size_t c = 0; c < all.columns.size(); ++c) {
      const Vector<std::byte>& rows = window.columns[c].rows;
      all.columns[c].rows.insert(all.columns[c].rows.end(), rows.begin(), rows.end());
    }
    window = {};
  }
  all.vertices = all.cells.connectivity;
  std::sort(all.vertices.begin(), all.vertices.end());
  all.vertices.erase(std::unique(all.vertices.begin(), all.vertices.end()), all.vertices.end());
}

// Among those that tetrahedra use.
template <class Real>
void Scatterer<Real>::find_coincident() {
  const auto is_used = [&](std::size_t v) { return table_.is_used(static_cast<VertexId>(v)); };
  coincident_.assign(stream_.points(), false);
  tetfusion::find_coincident<Real>(
      stream_, context_, is_used, [](std::uint64_t, std::uint64_t) {},
      [&](VertexId later, VertexId earlier) {
        for (const VertexId v : {later, earlier}) {
          if (!coincident_[v]) ++out_.coincident_points;
          coincident_[v] = true;
        }
      });
  if (out_.coincident_points == 0) coincident_ = {};
}

template <class Real>
void Scatterer<Real>::scatter_points(PieceStore* to) {
  const std::uint64_t points = stream_.points();
  if (settings_.lock_coincident) find_coincident();
  loose_.resize(block_count(points, settings_.point_window));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t width = steering_.width();
  boxes_.assign(loose_.size(), {std::vector(width, kInfinity), std::vector(width, -kInfinity)});
  std::atomic<std::size_t> done{0};
  for_each_block(points, settings_.point_window,
                 [&](std::size_t w, std::size_t begin, std::size_t end) {
                   context_.check();
                   const auto memory = budget_->wait_for(kWindowMemory, "a window of the input");
                   scatter_point_window(w, begin, end - begin, to);
                   context_.report("reading", 0.09, 0.12, ++done, loose_.size());
                 });
  to->seal();
  point_scratch_.clear();
  join_boxes();
  LowerPart<Real>& all = out_.lower;
  all.loose_columns = layout_.point_columns;
  for (LooseWindow& window : loose_) {
    all.loose_ids.insert(all.loose_ids.end(), window.ids.begin(), window.ids.end());
    all.loose_positions.insert(all.loose_positions.end(), window.positions.begin(),
                               window.positions.end());
    for (std::size_t c = 0; c < window.columns.size(); ++c) {
      const Vector<std::byte>& rows = window.columns[c].rows;
      all.loose_columns[c].rows.insert(all.loose_columns[c].rows.end(), rows.begin(), rows.end());
    }
    window = {};
  }
}

template <class Real>
void Scatterer<Real>::scatter_point_window(std::size_t window, std::uint64_t first,
                                           std::uint64_t count, PieceStore* to) {
  auto scratch = point_scratch_.borrow();
  Vector<Vec3<Real>>& positions = scratch->positions;
  positions.resize(count);
  stream_.read_points(first, count, std::as_writable_bytes(std::span(positions)));
  std::vector<Column>& columns = scratch->columns;
  if (columns.empty()) columns = layout_.point_columns;
  read_columns(stream_, Association::kPoint, carried_.point_indices, first, count, &columns);
  const std::size_t width = steering_.width();
  Vector<double>& steering = scratch->steering;
  steering.resize(count * width);
  Vector<std::uint8_t> locked(count, std::uint8_t{0});
  steering_.read(first, count, steering.data(), locked.data());
  stream_.read_locks(first, count, locked.data());
  if (settings_.interest != nullptr) {
    const auto read = [&](std::size_t array, std::span<std::byte> rows) {
      stream_.read_rows(Association::kPoint, array, first, count, rows);
    };
    Vector<std::uint8_t> inside(count, std::uint8_t{0});
    settings_.interest->mark<Real>(positions, read, inside.data());
    std::uint64_t all_inside = 0;
    for (std::size_t i = 0; i < count; ++i) {
      locked[i] |= inside[i];
      all_inside += inside[i];
    }
    std::atomic_ref(out_.interesting_points).fetch_add(all_inside, std::memory_order_relaxed);
  }

  for (std::size_t i = 0; i < count && !coincident_.empty(); ++i) {
    if (coincident_[first + i]) locked[i] = 1;
  }

  // A point on the interface goes to several chunks.
  const Vector<VertexId>& carried = out_.lower.vertices;
  auto next_carried =
      std::lower_bound(carried.begin(), carried.end(), static_cast<VertexId>(first));
  Vector<std::uint8_t> marks(count);
  Vector<std::uint32_t> last(count);              // of its chunks
  Vector<std::uint32_t>& items = scratch->items;  // the point of each piece's row
  Vector<std::uint32_t>& chunk_of = scratch->chunk_of;
  items.clear();
  chunk_of.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = static_cast<VertexId>(first + i);
    const std::size_t before = chunk_of.size();
    table_.chunks_of(v, &chunk_of);
    // Behind all others.
    const bool in_excerpt = chunk_of.size() > before && chunk_of.back() == chunks_;
    const std::size_t chunks = chunk_of.size() - before - (in_excerpt ? 1 : 0);
    last[i] = chunks > 0 && settings_.sample == nullptr ? chunk_of[before + chunks - 1] : 0;
    if (settings_.sample != nullptr) keep_sampled(before, &chunk_of);
    items.insert(items.end(), chunk_of.size() - before, static_cast<std::uint32_t>(i));
    const bool is_carried = next_carried != carried.end() && *next_carried == v;
    if (is_carried) ++next_carried;
    marks[i] = static_cast<std::uint8_t>((chunks > 1 ? kOnInterface : 0) |
                                         (is_carried || locked[i] != 0 ? kLocked : 0));
    if (chunks > 0) note_values(window, steering.data() + i * width);
    if (chunks > 0 || !is_carried) continue;
    LooseWindow& loose = loose_[window];
    if (loose.columns.empty()) loose.columns = layout_.point_columns;
    loose.ids.push_back(v);
    loose.positions.push_back(positions[i]);
    for (std::size_t c = 0; c < columns.size(); ++c) append_row(columns[c], i, &loose.columns[c]);
  }
  scratch->pieces.add(
      static_cast<std::uint32_t>(window), chunk_of, made_chunks(), to,
      [&](std::span<const std::uint32_t> places, RowWriter* writer) {
        writer->put<VertexId>(
            places, [&](std::size_t i) { return static_cast<VertexId>(first + items[i]); });
        writer->put<std::uint8_t>(places, [&](std::size_t i) {
          const bool is_last = chunk_of[i] == last[items[i]];
          const auto mark = static_cast<std::uint8_t>(marks[items[i]] | (is_last ? kLast : 0));
          return chunk_of[i] == chunks_ ? marks_in_excerpt(first + items[i], mark) : mark;
        });
        writer->put<Vec3<Real>>(places, [&](std::size_t i) { return positions[items[i]]; });
        for (std::size_t k = 0; k < width; ++k) {
          writer->put<double>(places,
                              [&](std::size_t i) { return steering[items[i] * width + k]; });
        }
        for (const Column& c : columns) writer->put_rows(c, places, items);
      });
}

// Of the chunks of a point, which begin there.
template <class Real>
void Scatterer<Real>::keep_sampled(std::size_t begin, Vector<std::uint32_t>* chunk_of) const {
  const auto first = chunk_of->begin() + static_cast<std::ptrdiff_t>(begin);
  const bool has = std::any_of(first, chunk_of->end(), [&](auto c) { return is_made(c); });
  chunk_of->resize(begin);
  if (has) chunk_of->push_back(0);
}

template <class Real>
void Scatterer<Real>::note_values(std::size_t window, const double* values) {
  SteeringBox& box = boxes_[window];
  for (const SteeringField& f : steering_.fields()) {
    const std::span<const double> of_field(values + f.first, f.count);
    if (!std::ranges::all_of(of_field, [](double v) { return std::isfinite(v); })) continue;
    for (std::size_t k = f.first; k < f.first + f.count; ++k) {
      box.low[k] = std::min(box.low[k], values[k]);
      box.high[k] = std::max(box.high[k], values[k]);
    }
  }
}

template <class Real>
void Scatterer<Real>::join_boxes() {
  if (boxes_.empty()) return;
  SteeringBox& all = out_.steering_box = boxes_.front();
  for (const SteeringBox& box : boxes_) {
    for (std::size_t k = 0; k < all.low.size(); ++k) {
      all.low[k] = std::min(all.low[k], box.low[k]);
      all.high[k] = std::max(all.high[k], box.high[k]);
    }
  }
}

}  // namespace

template <class Real>
ScatteredMesh<Real> scatter_mesh(const MeshStream& stream, const CarriedArrays& carried,
                                 const Steering& steering, const ScatterSettings& settings,
                                 const WorkMesh<Real>& layout, const RunContext& context,
                                 PhaseClock* clock, MemoryBudget* budget, Scratch* scratch) {
  return Scatterer<Real>(stream, carried, steering, settings, layout, context, budget)
      .run(clock, scratch);
}

template ScatteredMesh<float> scatter_mesh(const MeshStream&, const CarriedArrays&, const Steering&,
                                           const ScatterSettings&, const WorkMesh<float>&,
                                           const RunContext&, PhaseClock*, MemoryBudget*, Scratch*);
template ScatteredMesh<double> scatter_mesh(const MeshStream&, const CarriedArrays&,
                                            const Steering&, const ScatterSettings&,
                                            const WorkMesh<double>&, const RunContext&, PhaseClock*,
                                            MemoryBudget*, Scratch*);

}  // namespace tetfusion
