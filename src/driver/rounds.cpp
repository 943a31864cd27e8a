#include "driver/rounds.h"

#include <algorithm>

#include "base/tasks.h"

namespace tetfusion {

namespace {

struct ChunkResult {
  PassStatistics pass;
  FuseLog log;  // ids are the whole mesh's of the round
};

// The quota of tetrahedra [begin, end) out of all.
std::uint64_t share_of(std::uint64_t quota, std::uint64_t begin, std::uint64_t end,
                       std::uint64_t all) {
  if (quota >= all) return quota;
  return quota * end / all - quota * begin / all;
}

void add(const PassStatistics& from, PassStatistics* to) {
  to->tets_before += from.tets_before;
  to->tets_after += from.tets_after;
  to->fused += from.fused;
  to->labelled += from.labelled;
  for (std::size_t r = 0; r < kRejectReasons; ++r) to->rejected[r] += from.rejected[r];
}

void append(const FuseLog& from, std::span<const VertexId> point_ids, FuseLog* to) {
  for (FuseRecord record : from.records) {
    for (VertexId& v : record.points) v = point_ids[v];
    to->records.push_back(record);
  }
  to->nearest.insert(to->nearest.end(), from.nearest.begin(), from.nearest.end());
}

}  // namespace

template <class Real>
Rounds<Real>::Rounds(std::uint64_t chunk_tets, int threads)
    : chunk_tets_(chunk_tets), threads_(threads), workers_(static_cast<std::size_t>(threads)) {}

template <class Real>
RoundStatistics Rounds<Real>::run(const PassLimits& limits, std::span<const SteeringField> fields,
                                  const RunContext& context, WorkMesh<Real>* mesh, FuseLog* log) {
  if (mesh->tets.size() <= chunk_tets_) {  // one chunk: nothing to cut, copy or join
    context.check();
    return {workers_[0].pass.run(limits, fields, mesh, log), 1};
  }
  const Chunking chunking = cut_into_chunks(*mesh, chunk_tets_, limits.number);
  const std::uint64_t tets = mesh->tets.size();
  std::vector<ChunkResult> results(chunking.chunks());
  std::vector<ChunkRemains> remains(chunking.chunks());
  std::uint64_t removed = 0;  // counts only where chunks are worked one after another
  run_tasks(chunking.chunks(), limits.spread ? threads_ : 1, [&](std::size_t c, std::size_t w) {
    context.check();
    Worker& worker = workers_[w];
    const std::uint64_t begin = chunking.begins[c];
    PassLimits own = limits;
    own.quota = limits.spread ? share_of(limits.quota, begin, chunking.begins[c + 1], tets)
                              : limits.quota - removed;
    WorkMesh<Real> chunk = worker.cutter.take(*mesh, chunking, c);
    results[c].pass = worker.pass.run(own, fields, &chunk, &results[c].log);
    remains[c] = put_back(std::move(chunk), mesh);
    if (!limits.spread) removed += results[c].pass.tets_before - results[c].pass.tets_after;
  });

  RoundStatistics statistics;
  statistics.chunks = chunking.chunks();
  for (const ChunkResult& result : results) {
    add(result.pass, &statistics.pass);
    append(result.log, mesh->point_ids, log);
  }
  log->pass_ends.push_back(log->records.size());
  join_chunks(std::move(remains), mesh);
  return statistics;
}

template class Rounds<float>;
template class Rounds<double>;

}  // namespace tetfusion
