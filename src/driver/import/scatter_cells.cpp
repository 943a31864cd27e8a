#include <algorithm>
#include <atomic>
#include <numeric>
#include <span>

#include "base/blocks.h"
#include "base/pool.h"
#include "driver/import/scatter_passes.h"
#include "driver/rounds/windows.h"

namespace tetfusion {

namespace {

// Where the layout has a column more than the input has arrays, it is for these.
void number_cells(std::uint64_t first, std::uint64_t count, Column* column) {
  column->resize(count);
  auto* numbers = reinterpret_cast<TetId*>(column->rows.data());
  std::iota(numbers, numbers + count, static_cast<TetId>(first));
}

template <class Real>
class CellScatterer {
 public:
  CellScatterer(ScatterJob<Real>* job, PieceStore* to)
      : job_(*job), to_(to), windows_(block_count(job->stream.cells(), window_size())) {
    chunk_tets_.assign(job->chunks, 0);
  }

  void run(ScatteredMesh<Real>* out) {
    std::atomic<std::size_t> done{0};
    for_each_block(job_.stream.cells(), window_size(),
                   [&](std::size_t w, std::size_t begin, std::size_t end) {
                     job_.context.check();
                     const auto memory = job_.wait_for(job_.cell_window);
                     scatter_window(static_cast<std::uint32_t>(w), begin, end - begin);
                     job_.context.report("reading", 0.02, 0.09, ++done, windows_.size());
                   });
    to_->seal();
    job_.table.finish();
    for (const Window& window : windows_) {
      out->tet_count += window.tets;
      out->ghost_cells += window.ghosts;
    }
    out->chunk_tets = std::move(chunk_tets_);
    join_lower(&out->lower);
  }

 private:
  // What is left of one when its tetrahedra are in their chunks.
  struct Window {
    std::uint64_t tets = 0, ghosts = 0;
    LowerCells lower;
    std::vector<Column> lower_columns;
  };
  struct Scratch {
    CellWindow cells;
    std::vector<Column> columns;
    Vector<std::uint32_t> chunk_of;
    WindowPieces pieces;
  };

  std::size_t window_size() const { return job_.cell_window.rows; }
  void scatter_window(std::uint32_t window, std::uint64_t first, std::uint64_t count);
  void count_tets(std::span<const std::uint32_t> chunk_of);
  void take_lower(const Scratch& scratch, std::uint64_t first, Window* window) const;
  void keep_sampled(Scratch* scratch) const;
  void add_to_excerpt(Scratch* scratch);
  void join_lower(LowerPart<Real>* all);

  ScatterJob<Real>& job_;
  PieceStore* to_;
  std::vector<Window> windows_;
  Vector<std::uint64_t> chunk_tets_;
  Pool<Scratch> scratch_;
};

template <class Real>
void CellScatterer<Real>::scatter_window(std::uint32_t window, std::uint64_t first,
                                         std::uint64_t count) {
  auto scratch = scratch_.borrow();
  CellWindow& cells = scratch->cells;
  job_.stream.read_cells(first, count, &cells);
  std::vector<Column>& columns = scratch->columns;
  if (columns.empty()) columns = job_.layout.cell_columns;
  const std::vector<std::size_t>& arrays = job_.carried.cell_indices;
  read_columns(job_.stream, Association::kCell, arrays, first, count, &columns);
  if (columns.size() > arrays.size()) number_cells(first, count, &columns.back());
  windows_[window].tets = cells.tets.size();
  windows_[window].ghosts = cells.ghost_cells;
  take_lower(*scratch, first, &windows_[window]);

  Vector<std::uint32_t>& chunk_of = scratch->chunk_of;
  chunk_of.resize(cells.tets.size());
  VertexChunks::Notes notes(&job_.table);
  for (std::size_t t = 0; t < cells.tets.size(); ++t) chunk_of[t] = notes.add(cells.tets[t]);
  notes.hand_over();
  count_tets(chunk_of);
  for (std::uint64_t& row : cells.tet_rows) row -= first;
  if (job_.settings.sample != nullptr) keep_sampled(&*scratch);
  if (!job_.excerpt.empty()) add_to_excerpt(&*scratch);
  scratch->pieces.add(window, chunk_of, job_.made_chunks(), to_,
                      [&](std::span<const std::uint32_t> items, RowWriter* writer) {
                        writer->put<Tet>(items, [&](std::size_t t) { return cells.tets[t]; });
                        for (const Column& c : columns) writer->put_rows(c, items, cells.tet_rows);
                      });
}

// Not by the bytes of pieces, which depend on how many windows there are.
template <class Real>
void CellScatterer<Real>::count_tets(std::span<const std::uint32_t> chunk_of) {
  for (std::size_t begin = 0, end = 0; begin < chunk_of.size(); begin = end) {
    while (end < chunk_of.size() && chunk_of[end] == chunk_of[begin]) ++end;
    std::atomic_ref(chunk_tets_[chunk_of[begin]]).fetch_add(end - begin, std::memory_order_relaxed);
  }
}

template <class Real>
void CellScatterer<Real>::take_lower(const Scratch& scratch, std::uint64_t first,
                                     Window* window) const {
  if (scratch.cells.lower.size() == 0) return;
  window->lower = scratch.cells.lower;
  window->lower_columns = job_.layout.cell_columns;
  for (std::size_t c = 0; c < scratch.columns.size(); ++c) {
    window->lower_columns[c].rows.reserve(scratch.cells.lower_rows.size() *
                                          scratch.columns[c].stride());
    for (const std::uint64_t row : scratch.cells.lower_rows) {
      append_row(scratch.columns[c], row - first, &window->lower_columns[c]);
    }
  }
}

// Shows the sample all tetrahedra. Rows count from the window's first.
template <class Real>
void CellScatterer<Real>::keep_sampled(Scratch* scratch) const {
  CellWindow& cells = scratch->cells;
  Vector<std::uint32_t>& chunk_of = scratch->chunk_of;
  job_.settings.sample->add(cells.tets);
  const bool all_rows = cells.tet_rows.empty();
  if (all_rows) cells.tet_rows.resize(cells.tets.size());
  std::size_t kept = 0;
  for (std::size_t t = 0; t < cells.tets.size(); ++t) {
    if (chunk_of[t] != job_.sampled) continue;
    cells.tets[kept] = cells.tets[t];
    cells.tet_rows[kept++] = all_rows ? t : cells.tet_rows[t];
  }
  cells.tets.resize(kept);
  cells.tet_rows.resize(kept);
  chunk_of.assign(kept, 0);
}

// Copies of the tetrahedra that have a point of it.
template <class Real>
void CellScatterer<Real>::add_to_excerpt(Scratch* scratch) {
  CellWindow& cells = scratch->cells;
  VertexChunks::Notes notes(&job_.table);
  Vector<std::uint64_t>& rows = cells.tet_rows;
  const bool has_columns = !job_.layout.cell_columns.empty();
  const std::size_t count = cells.tets.size();
  for (std::size_t t = 0; t < count; ++t) {
    const Tet tet = cells.tets[t];
    if (std::ranges::none_of(tet, [&](VertexId v) { return job_.excerpt.has(v); })) continue;
    if (has_columns && rows.empty()) {
      rows.resize(count);
      std::iota(rows.begin(), rows.end(), std::uint64_t{0});
    }
    if (has_columns) rows.push_back(rows[t]);
    cells.tets.push_back(tet);
    scratch->chunk_of.push_back(job_.chunks);
    for (const VertexId v : tet) notes.add(v, job_.chunks);
  }
  notes.hand_over();
}

template <class Real>
void CellScatterer<Real>::join_lower(LowerPart<Real>* all) {
  all->columns = job_.layout.cell_columns;
  const LowerCount count = job_.stream.lower_cells();
  all->cells.types.reserve(count.cells);
  all->cells.offsets.reserve(count.cells + 1);
  all->cells.connectivity.reserve(count.corners);
  for (Column& c : all->columns) c.rows.reserve(count.cells * c.stride());
  for (Window& window : windows_) {
    const LowerCells& cells = window.lower;
    if (cells.size() == 0) continue;
    all->cells.add(cells);
    append_rows(window.lower_columns, &all->columns);
    window = {};
  }
  all->vertices = all->cells.connectivity;
  if (all->columns.size() > job_.carried.cell_indices.size()) {
    const Column& numbers = all->columns.back();
    const auto* first = reinterpret_cast<const TetId*>(numbers.rows.data());
    all->numbers.assign(first, first + all->cells.size());
    all->columns.pop_back();
  }
  std::sort(all->vertices.begin(), all->vertices.end());
  all->vertices.erase(std::unique(all->vertices.begin(), all->vertices.end()), all->vertices.end());
}

}  // namespace

template <class Real>
void scatter_cells(ScatterJob<Real>* job, PieceStore* to, ScatteredMesh<Real>* out) {
  CellScatterer<Real>(job, to).run(out);
}

template void scatter_cells(ScatterJob<float>*, PieceStore*, ScatteredMesh<float>*);
template void scatter_cells(ScatterJob<double>*, PieceStore*, ScatteredMesh<double>*);

}  // namespace tetfusion
