// Rounds: the mesh is cut into chunks, a greedy pass runs over each of them, side by side, and the
// chunks are joined again. A round makes one macroLoD.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/run_context.h"
#include "kernel/fuse_log.h"
#include "kernel/greedy_pass.h"
#include "mesh/work_mesh.h"
#include "partition/chunks.h"

namespace tetfusion {

struct RoundStatistics {
  PassStatistics pass;  // summed over the chunks
  std::uint64_t chunks = 1;
};

// Keeps the threads' scratch memory from round to round.
template <class Real>
class Rounds {
 public:
  // Both at least 1. The result depends on chunk_tets, not on threads.
  Rounds(std::uint64_t chunk_tets, int threads);

  // One round. The limits' quota is shared among the chunks by their sizes; without limits.spread
  // the chunks are worked one after another, each with what is left of it. Fusions are appended to
  // the log, chunk by chunk. Throws Error(kInterrupted) between two chunks when the context says
  // so; the mesh is of no use then.
  RoundStatistics run(const PassLimits& limits, std::span<const SteeringField> fields,
                      const RunContext& context, WorkMesh<Real>* mesh, FuseLog* log);

 private:
  struct Worker {
    ChunkCutter<Real> cutter;
    GreedyPass<Real> pass;
  };

  std::uint64_t chunk_tets_;
  int threads_;
  std::vector<Worker> workers_;
};

extern template class Rounds<float>;
extern template class Rounds<double>;

}  // namespace tetfusion
