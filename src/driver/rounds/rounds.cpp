#include "driver/rounds/rounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/tasks.h"
#include "kernel/quadrics/vertex_quadrics.h"
#include "partition/id_ranges.h"

namespace tetfusion {

namespace {

// A chunk is put away when a pass over it has fused less than this share of its tetrahedra.
constexpr double kIdleShare = 0.04;

// Does a chunk's quota depend on what those before it have taken?
bool in_turn(const PassLimits& limits, std::uint64_t tets) {
  return !limits.spread && limits.quota < tets;
}

// What a chunk may take of a quota that is spread; `begin` and `end` are its share of `all`.
std::uint64_t quota_of(const PassLimits& limits, std::uint64_t tets, std::uint64_t begin,
                       std::uint64_t end, std::uint64_t all) {
  if (limits.quota >= tets) return limits.quota;
  const auto up_to = [&](std::uint64_t share) {
    return static_cast<std::uint64_t>(static_cast<double>(limits.quota) *
                                      (static_cast<double>(share) / static_cast<double>(all)));
  };
  return up_to(end) - up_to(begin);
}

void add(const FuseStatistics& from, FuseStatistics* to) {
  to->pass.tets_before += from.pass.tets_before;
  to->pass.tets_after += from.pass.tets_after;
  to->pass.fused += from.pass.fused;
  to->pass.labelled += from.pass.labelled;
  for (std::size_t r = 0; r < kRejectReasons; ++r) to->pass.rejected[r] += from.pass.rejected[r];
  for (std::size_t b = 0; b < kCostBins; ++b) to->costs[b] += from.costs[b];
  to->deviation = std::max(to->deviation, from.deviation);
}

template <class Real>
void lock(const Vector<VertexId>& ids, WorkMesh<Real>* mesh) {
  if (ids.empty()) return;
  for (std::size_t v = 0; v < mesh->vertex_count(); ++v) {
    if (std::binary_search(ids.begin(), ids.end(), mesh->point_ids[v])) mesh->marks[v] |= kLocked;
  }
}

template <class Real>
PassStatistics run_greedy_passes(int passes, PassLimits limits,
                                 std::span<const SteeringField> fields, WorkMesh<Real>* mesh,
                                 FusionLog* log) {
  GreedyPass<Real> pass;
  PassStatistics all;
  all.tets_before = mesh->tets.size();
  limits.number = kFirstPassNumber;
  for (int i = 0; i < passes; ++i, ++limits.number) {
    const PassStatistics one = pass.run(limits, fields, mesh, log);
    all.fused += one.fused;
    all.labelled = one.labelled;
    all.rejected = one.rejected;
    all.tets_after = one.tets_after;
    limits.quota -= std::min(limits.quota, one.removed());
    if (static_cast<double>(one.removed()) <= kIdleShare * static_cast<double>(one.tets_before))
      break;
  }
  return all;
}

}  // namespace

std::uint64_t chunk_memory(std::uint64_t piece_bytes) { return kCopiesOfChunk * piece_bytes; }

template <class Real>
Rounds<Real>::Rounds(const WorkMesh<Real>& layout, int threads, MemoryBudget* budget,
                     Scratch* scratch)
    : layout_(layout), budget_(budget), scratch_(scratch) {
  for (int i = 0; i < std::max(threads, 1); ++i) {
    workers_.push_back(std::make_unique<Worker>(layout));
  }
}

template <class Real>
void Rounds<Real>::watch(std::function<void(std::uint64_t)> watcher) {
  watcher_ = std::move(watcher);
}

template <class Real>
void Rounds<Real>::release_memory() {
  for (auto& worker : workers_) worker = std::make_unique<Worker>(layout_);
}

template <class Real>
void Rounds<Real>::gather(const MacroLod<Real>& mesh, std::uint32_t chunk,
                          ChunkGather<Real>* gather, WorkMesh<Real>* out) {
  gather->gather(chunk, *mesh.pieces, mesh.interface, out);
  lock(mesh.locks, out);
}

// Passes over one chunk, or the whole mesh, with limits of its own. What they take is free again
// in between, for whoever puts the next chunk together and inspects it.
template <class Real>
FuseStatistics Rounds<Real>::run_passes(const PassLimits& own, WorkMesh<Real>* mesh,
                                        FusionLog* log) {
  const RoundSettings& settings = round_.settings;
  if (settings.method == Method::kTetFuse) {
    return {run_greedy_passes(settings.passes, own, round_.fields, mesh, log)};
  }
  FuseLimits fuse = settings.fuse;
  fuse.quota = own.quota;
  fuse.paper = own.paper;
  if (fuse.sheets_move()) {
    fuse.facing = round_.facing.empty() ? nullptr : &round_.facing;
    fuse.facing_after = &round_.next_facing;
    fuse.marks_are_known = !settings.is_first;
  }
  if (settings.is_first) begin_quadrics(round_.fields, fuse.unit, mesh);
  FuseRound<Real> round;
  if (settings.look) return round.look(fuse, round_.fields, mesh);
  if (watcher_) {
    round.watch([this](std::uint64_t gone) {
      const std::uint64_t all = gone_.fetch_add(gone, std::memory_order_relaxed) + gone;
      watcher_(round_.tets - all);
    });
  }
  return round.run(fuse, round_.fields, mesh, log);
}

template <class Real>
CostHistogram Rounds<Real>::look(const RoundSettings& settings,
                                 std::span<const SteeringField> fields, WorkMesh<Real>* mesh) {
  begin_quadrics(fields, settings.fuse.unit, mesh);
  return FuseRound<Real>().look(settings.fuse, fields, mesh).costs;
}

// By the chunks that will have the vertices.
template <class Real>
void Rounds<Real>::count_costs(const WorkMesh<Real>& mesh, const ChunkScatter<Real>& scatter) {
  const std::lock_guard lock(costs_mutex_);
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) {
    const float cost = known_cost(mesh, v);
    const std::uint32_t chunk = scatter.chunk_of(v);
    if (cost > 0 && chunk != kNoVertex) ++round_.costs[chunk][cost_bin(cost)];
  }
}

// What each chunk has, up to it, of what may be removed: its bytes, or the vertices that are cheap
// enough.
template <class Real>
std::vector<std::uint64_t> Rounds<Real>::shares_of(const RoundSettings& settings,
                                                   const MacroLod<Real>& mesh) const {
  std::vector<std::uint64_t> shares{0};
  const std::size_t bins =
      settings.method == Method::kFuse ? cost_bin(settings.fuse.threshold) + 1 : 0;
  for (std::uint32_t c = 0; c < mesh.chunks && !mesh.costs.empty(); ++c) {
    const ChunkCosts& costs = mesh.costs[c];
    shares.push_back(std::accumulate(
        costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(bins), shares.back()));
  }
  if (shares.back() > 0) return shares;
  shares = {0};
  for (std::uint32_t c = 0; c < mesh.chunks; ++c) {
    shares.push_back(shares.back() + mesh.pieces->bytes(c));
  }
  return shares;
}

template <class Real>
void Rounds<Real>::begin_round(const RoundSettings& settings, std::span<const SteeringField> fields,
                               std::uint64_t tets) {
  round_ = {};
  round_.settings = settings;
  round_.fields = fields;
  round_.tets = tets;
  gone_ = 0;
  if (settings.fuse.sheets_move()) {
    const auto& [lo, hi] = settings.box;
    round_.next_facing.reset({{lo.x, lo.y, lo.z}, {hi.x, hi.y, hi.z}});
  }
  if (puts_values_aside()) values_->begin();
}

template <class Real>
FuseStatistics Rounds<Real>::run_whole(const RoundSettings& settings,
                                       std::span<const SteeringField> fields,
                                       MacroLod<Real>* mesh) {
  WorkMesh<Real>& whole = *mesh->whole;
  PassLimits limits = settings.limits;
  constexpr std::uint32_t kNumbers =
      std::numeric_limits<std::uint16_t>::max() - std::uint32_t{kFirstPassNumber};
  limits.number = static_cast<std::uint16_t>(settings.number % kNumbers + kFirstPassNumber);
  const bool is_by_number = settings.method == Method::kTetFuse;  // what the mesh remembers
  if (is_by_number && limits.number == kFirstPassNumber) {
    std::fill(whole.remembered.begin(), whole.remembered.end(), std::uint16_t{0});
  }
  if (limits.boundary_rule == BoundaryRule::kTets) mark_near_boundary(&whole);
  FuseStatistics statistics;
  FusionLog log;
  if (settings.method == Method::kTetFuse) {
    statistics.pass = GreedyPass<Real>().run(limits, fields, &whole, wanted(&log));
  } else {
    begin_round(settings, fields, mesh->tets);
    round_.facing = std::move(mesh->facing);
    if (puts_values_aside()) {
      values_->add(0, whole);
      values_->end();
    }
    statistics = run_passes(limits, &whole, wanted(&log));
    mesh->facing = std::move(round_.next_facing);
  }
  mesh->tets = whole.tets.size();
  if (logs_ != nullptr) {
    logs_->begin(statistics.pass.tets_before);
    logs_->add(0, log);
    logs_->end();
  }
  return statistics;
}

template <class Real>
RoundStatistics Rounds<Real>::run(const RoundSettings& settings,
                                  std::span<const SteeringField> fields, const RunContext& context,
                                  MacroLod<Real>* mesh) {
  context.check();
  if (mesh->whole) return {run_whole(settings, fields, mesh)};
  begin(settings, fields, {mesh->tets, shares_of(settings, *mesh), mesh->samples, mesh->removed});
  round_.facing = std::move(mesh->facing);
  const auto work_on = [&](std::size_t c, std::size_t w) {
    context.check();
    const auto chunk = static_cast<std::uint32_t>(c);
    const auto memory =
        budget_->wait_for(chunk_memory(mesh->pieces->bytes(chunk)), "a chunk in work");
    context.check();  // that may have taken long
    const std::size_t ahead = c + workers_.size();
    if (ahead < mesh->chunks) mesh->pieces->will_read(static_cast<std::uint32_t>(ahead));
    WorkMesh<Real>& work_mesh = workers_[w]->mesh;
    gather(*mesh, chunk, &workers_[w]->gather, &work_mesh);
    mesh->pieces->forget(chunk);
    work(chunk, w, &work_mesh);
  };
  if (in_turn(settings.limits, round_.tets)) {
    for (std::size_t c = 0; c < mesh->chunks; ++c) work_on(c, 0);
  } else {
    run_tasks(mesh->chunks, static_cast<int>(workers_.size()), work_on);
  }
  return end(mesh);
}

template <class Real>
void Rounds<Real>::begin(const RoundSettings& settings, std::span<const SteeringField> fields,
                         MeshInChunks<Real> mesh) {
  begin_round(settings, fields, mesh.tets);
  round_.quota_left = settings.limits.quota;
  round_.shares = std::move(mesh.shares);
  round_.results.resize(round_.shares.size() - 1);
  round_.next = scratch_->begin(fmt::format("round-{}", settings.number));
  if (logs_ != nullptr) logs_->begin(mesh.tets);
  // By what the mesh will about have shrunk to.
  const double expected = settings.shrink * static_cast<double>(mesh.tets) +
                          static_cast<double>(mesh.removed / kRemovedPerTet);
  const auto chunks =
      static_cast<std::uint32_t>(std::ceil(expected / static_cast<double>(settings.chunk_tets)));
  if (settings.method == Method::kFuse) round_.costs.resize(std::max(chunks, 1U));
  if (chunks <= 1) return;
  const ShiftedCurve curve(without_outliers<Real>(settings.box, mesh.samples), settings.number);
  Vector<std::uint64_t> keys;
  keys.reserve(mesh.samples.size());
  for (const Vec3<Real>& p : mesh.samples) keys.push_back(curve.key(p));
  round_.next_cut = CurveCut(curve, chunks, std::move(keys));
}

template <class Real>
void Rounds<Real>::work(std::uint32_t chunk, std::size_t worker, WorkMesh<Real>* mesh) {
  PassLimits own = round_.settings.limits;
  if (own.boundary_rule == BoundaryRule::kTets) mark_near_boundary(mesh);
  const bool is_in_turn = in_turn(own, round_.tets);
  own.quota = is_in_turn ? round_.quota_left
                         : quota_of(own, round_.tets, round_.shares[chunk],
                                    round_.shares[chunk + 1], round_.shares.back());
  ChunkResult& result = round_.results[chunk];
  Worker& tools = *workers_[worker];
  FusionLog log;
  if (puts_values_aside()) values_->add(chunk, *mesh);
  result.statistics = run_passes(own, mesh, wanted(&log));
  if (logs_ != nullptr) logs_->add(chunk, log);
  if (is_in_turn) round_.quota_left -= result.statistics.pass.removed();
  tools.scatter.scatter(*mesh, round_.next_cut, chunk, round_.next.get(), &result.interface);
  sort_by_id(&result.interface);
  result.sizes = tools.scatter.sizes();
  if (!round_.costs.empty()) count_costs(*mesh, tools.scatter);
  const std::uint64_t step =
      std::max<std::uint64_t>(1, round_.settings.chunk_tets / kSamplesPerChunk);
  for (std::size_t t = 0; t < mesh->tets.size(); t += step) {
    result.samples.push_back(mesh->positions[mesh->tets[t][0]]);
  }
  const Vector<Vec3<Real>>& removed = mesh->removed.positions;
  for (std::size_t p = 0; p < removed.size(); p += kRemovedPerTet * step) {
    result.samples.push_back(removed[p]);
  }
  result.removed_points = removed.size();
}

template <class Real>
void Rounds<Real>::drop() {
  if (puts_values_aside()) values_->begin();
  if (logs_ != nullptr) logs_->begin(0);
  round_ = {};
}

template <class Real>
RoundStatistics Rounds<Real>::end(MacroLod<Real>* mesh, const InterfaceTable& marks) {
  MacroLod<Real> next;
  if (puts_values_aside()) values_->end();
  next.chunks = round_.next_cut.chunks();
  next.cut = std::move(round_.next_cut);
  next.pieces = std::move(round_.next);
  next.pieces->seal();
  next.costs = std::move(round_.costs);
  next.facing = std::move(round_.next_facing);
  next.sizes.resize(next.chunks);
  RoundStatistics statistics;
  statistics.chunks = round_.results.size();
  std::vector<Vector<InterfaceReport>> reports;
  if (logs_ != nullptr) logs_->end();
  for (ChunkResult& result : round_.results) {
    add(result.statistics, &statistics);
    reports.push_back(std::move(result.interface));
    next.samples.insert(next.samples.end(), result.samples.begin(), result.samples.end());
    next.removed += result.removed_points;
    for (const auto& size : result.sizes) {
      next.sizes[size.bucket].free_points += size.free_vertices;
      next.sizes[size.bucket].tets += size.tets;
    }
    result = {};
  }
  round_ = {};
  mesh->interface = {};
  next.tets = statistics.pass.tets_after;
  next.interface = InterfaceTable(std::move(reports));
  next.interface.add_marks(marks);
  *mesh = std::move(next);
  if (mesh->chunks == 1) make_whole(mesh);
  return statistics;
}

// One chunk needs no pieces.
template <class Real>
void Rounds<Real>::make_whole(MacroLod<Real>* mesh) {
  WorkMesh<Real> whole(layout_);
  gather(*mesh, 0, &workers_[0]->gather, &whole);
  mesh->whole = std::move(whole);
  mesh->pieces.reset();
  mesh->interface = {};
  mesh->sizes.clear();
}

template class Rounds<float>;
template class Rounds<double>;

}  // namespace tetfusion
