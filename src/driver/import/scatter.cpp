#include "driver/import/scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <span>

#include "base/blocks.h"
#include "driver/arrays/rows_in_use.h"
#include "driver/import/scatter_passes.h"
#include "partition/curve_excerpt.h"

namespace tetfusion {

namespace {

// A point of an excerpt takes about ten tetrahedra, and two points beside it: so that it is no
// larger than a chunk.
constexpr std::uint64_t kTetsAPoint = 16;

std::uint32_t count_chunks(std::uint64_t cells, std::uint64_t chunk_tets) {
  const std::uint64_t chunks = block_count(cells, chunk_tets);
  if (chunks > VertexChunks::kMaxChunks) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--chunk-tets {} would cut this mesh into {} chunks; at most {} are "
                            "possible: give at least {}",
                            chunk_tets, chunks, VertexChunks::kMaxChunks,
                            block_count(cells, VertexChunks::kMaxChunks)));
  }
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(chunks, 1));
}

std::uint64_t bytes_of(const std::vector<Column>& columns) {
  std::uint64_t bytes = 0;
  for (const Column& c : columns) bytes += c.stride();
  return bytes;
}

bool all_are_used(const VertexChunks& table) {
  std::size_t v = 0;
  while (v < table.points() && table.is_used(static_cast<VertexId>(v))) ++v;
  return v == table.points();
}

// f(window, first, positions) for each window of points.
template <class Real, class F>
void for_each_window(const ScatterJob<Real>& job, F f) {
  for_each_block(job.stream.points(), job.settings.point_window,
                 [&](std::size_t w, std::size_t begin, std::size_t end) {
                   job.context.check();
                   Vector<Vec3<Real>> positions(end - begin);
                   job.stream.read_points(begin, end - begin,
                                          std::as_writable_bytes(std::span(positions)));
                   f(w, begin, positions);
                 });
}

// Points in use, where the numbers say that many may not be, as in what was cut out of a larger
// mesh; else all of them, and the cells need not be read once more.
template <class Real>
BitSet points_to_cut_by(const ScatterJob<Real>& job) {
  // About five or six where all are in use, in plates of one layer of cells two and a half.
  constexpr std::uint64_t kCellsAPoint = 2;
  if (job.chunks == 1 || kCellsAPoint * job.stream.points() <= job.stream.cells()) return {};
  return find_rows_in_use(job.stream, Association::kPoint, job.context);
}

// The box of those points, and every so-many-th of them. Returns how many they are.
template <class Real>
std::uint64_t survey_points(const ScatterJob<Real>& job, ScatteredMesh<Real>* out) {
  const BitSet wanted = points_to_cut_by(job);
  const std::uint64_t points = wanted.empty() ? job.stream.points() : wanted.count();
  const std::uint64_t step =
      std::max<std::uint64_t>(1, points / (kSamplesPerChunk * std::uint64_t{job.chunks}));
  struct Window {
    std::uint64_t before = 0;  // points of windows before it
    Box box;
    Vector<Vec3<Real>> samples;
  };
  const std::uint64_t rows = job.settings.point_window;
  std::vector<Window> windows(block_count(job.stream.points(), rows));
  for (std::size_t w = 1; w < windows.size(); ++w) {
    const std::uint64_t begin = (w - 1) * rows;
    windows[w].before =
        windows[w - 1].before + (wanted.empty() ? rows : wanted.count(begin, begin + rows));
  }
  for_each_window(job, [&](std::size_t w, std::size_t first, const Vector<Vec3<Real>>& positions) {
    std::uint64_t number = windows[w].before;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3<Real>& p = positions[i];
      if (!wanted.empty() && !wanted.has(first + i)) continue;
      windows[w].box.add({p.x, p.y, p.z});
      if (number++ % step == 0) windows[w].samples.push_back(p);
    }
  });
  for (const Window& window : windows) {
    out->box.add(window.box);
    if (job.chunks == 1) continue;
    out->samples.insert(out->samples.end(), window.samples.begin(), window.samples.end());
  }
  return points;
}

// The chunk nearest to the middle of those that have samples.
template <class Real>
std::uint32_t middle_chunk(const CurveCut& cut, std::span<const Vec3<Real>> samples) {
  const auto middle = static_cast<std::int64_t>(cut.chunks() / 2);
  std::int64_t nearest = std::numeric_limits<std::uint32_t>::max();
  for (const Vec3<Real>& p : samples) {
    const auto chunk = static_cast<std::int64_t>(cut.chunk_of(p));
    if (std::abs(chunk - middle) < std::abs(nearest - middle)) nearest = chunk;
  }
  return static_cast<std::uint32_t>(nearest);
}

// The first cut: a point's chunk by its place on the curve. So many points were surveyed.
template <class Real>
void find_homes(const ScatteredMesh<Real>& survey, std::uint64_t points, ScatterJob<Real>* job) {
  const ShiftedCurve curve(without_outliers<Real>(survey.box, survey.samples), 0);
  Vector<std::uint64_t> keys;
  for (const Vec3<Real>& p : survey.samples) keys.push_back(curve.key(p));
  CurveExcerpt excerpt;
  if (survey.has_excerpt) {
    excerpt = CurveExcerpt(points, job->settings.chunk_tets / kTetsAPoint, keys);
    job->excerpt.resize(job->stream.points());
  }
  const CurveCut cut(curve, job->chunks, std::move(keys));
  if (job->settings.sample != nullptr) job->sampled = middle_chunk<Real>(cut, survey.samples);
  for_each_window(*job, [&](std::size_t, std::size_t first, const Vector<Vec3<Real>>& positions) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const auto v = static_cast<VertexId>(first + i);
      const std::uint64_t key = curve.key(positions[i]);
      job->table.set_home(v, cut.chunk_of_key(key));
      if (excerpt.has(key)) job->excerpt.set_atomically(v);
    }
  });
}

}  // namespace

template <class Real>
ScatteredMesh<Real> scatter_mesh(const ImportInput& input, const ScatterSettings& settings,
                                 const WorkMesh<Real>& layout, const ImportPlace& place) {
  const std::uint32_t chunks = count_chunks(input.stream.cells(), settings.chunk_tets);
  ScatterJob<Real> job{
      input,
      settings,
      layout,
      place.context,
      place.budget,
      chunks,
      VertexChunks(input.stream.points()),
      {},
      plan_window(settings.cell_window, sizeof(Tet) + bytes_of(layout.cell_columns),
                  place.budget->total(), thread_count()),
      plan_window(settings.point_window,
                  sizeof(Vec3<Real>) + bytes_of(layout.point_columns) +
                      sizeof(double) * input.steering->width(),
                  place.budget->total(), thread_count())};
  ScatteredMesh<Real> out;
  out.all_chunks = chunks;
  out.chunks = settings.sample != nullptr ? 1 : chunks;
  out.has_excerpt = settings.excerpt && chunks > 1;
  place.clock->begin("locate");
  const std::uint64_t points = survey_points(job, &out);
  if (chunks > 1) find_homes(out, points, &job);
  place.clock->begin("scatter cells");
  out.tets = place.scratch->begin("tets");
  scatter_cells(&job, out.tets.get(), &out);
  if (!all_are_used(job.table)) {
    input.steering->relate_to([&](VertexId v) { return job.table.is_used(v); }, place.context);
  }
  place.clock->begin("scatter points");
  out.points = place.scratch->begin("points");
  scatter_points(job, out.points.get(), &out);
  return out;
}

template ScatteredMesh<float> scatter_mesh(const ImportInput&, const ScatterSettings&,
                                           const WorkMesh<float>&, const ImportPlace&);
template ScatteredMesh<double> scatter_mesh(const ImportInput&, const ScatterSettings&,
                                            const WorkMesh<double>&, const ImportPlace&);

}  // namespace tetfusion
