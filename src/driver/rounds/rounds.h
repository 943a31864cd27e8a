// Rounds: passes of TetFuse, or a round of fuse, run over each chunk of a macroLoD, side by side,
// and the chunks of the next macroLoD, cut elsewhere, are made of what is left.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/rounds/fusion_logs.h"
#include "driver/rounds/macro_lod.h"
#include "driver/rounds/original_values.h"
#include "io/store/scratch.h"
#include "kernel/fuse/fuse_round.h"
#include "kernel/greedy_pass.h"
#include "partition/chunk_pieces.h"

namespace tetfusion {

// Points that are remembered weigh in a chunk's size: so many are one more tetrahedron.
inline constexpr std::uint64_t kRemovedPerTet = 2;

// Of all chunks: fusions of all passes; why what is left was refused in the last ones.
struct RoundStatistics : FuseStatistics {
  std::uint64_t chunks = 1;
};

struct RoundSettings {
  Method method = Method::kTetFuse;
  // The quota is all chunks'; without `spread` they take it in turn, one after the other, each what
  // is left of it.
  PassLimits limits;
  FuseLimits fuse;               // with kFuse, whose quota and paper's limits are those above
  bool is_first = false;         // no vertex has a quadric yet
  bool look = false;             // nothing fuses, costs are counted
  Box box;                       // of the input
  std::uint64_t chunk_tets = 1;  // at least 1
  // Where the mesh is cut, a chunk that has been loaded is worked on until a pass fuses next to
  // nothing, but at most so often. Loading costs more than a pass.
  int passes = 1;
  std::uint32_t number = 1;  // of the round; ascending from 1: it shifts the cut
  double shrink =
      1;  // what the last round has left of the mesh: the next cut expects the same again
};

// What a round knows beforehand of a mesh whose chunks come one by one.
template <class Real>
struct MeshInChunks {
  std::uint64_t tets = 0;
  std::vector<std::uint64_t> shares;  // chunk c has about (shares[c + 1] - shares[c]) of the last
  const Vector<Vec3<Real>>& samples;  // places in it, for the next cut
  std::uint64_t removed = 0;          // MacroLod's
};

// Keeps the threads' scratch memory from round to round, unless it is told to release it.
template <class Real>
class Rounds {
 public:
  // `layout` is empty and says what a row holds; the rest outlives this.
  Rounds(const WorkMesh<Real>& layout, int threads, MemoryBudget* budget, Scratch* scratch);

  // One round. A function of the mesh and the settings alone. Throws Error(kInterrupted) between
  // two chunks when the context says so, and what the watcher throws; the mesh is of no use then.
  RoundStatistics run(const RoundSettings& settings, std::span<const SteeringField> fields,
                      const RunContext& context, MacroLod<Real>* mesh);

  // The same, with chunks that somebody else brings: begin() a round; work() on each chunk once,
  // each worker below `threads` on one at a time (without limits.spread one chunk after another, in
  // their order); and end() it, with the marks that vertices on the interface have got in the
  // meantime; or drop() it, and all that it has put aside. The fields live until then.
  void begin(const RoundSettings& settings, std::span<const SteeringField> fields,
             MeshInChunks<Real> mesh);
  void work(std::uint32_t chunk, std::size_t worker, WorkMesh<Real>* mesh);
  RoundStatistics end(MacroLod<Real>* mesh, const InterfaceTable& marks = {});
  void drop();

  // What fusions cost in a part of a mesh in which nothing has fused yet.
  CostHistogram look(const RoundSettings& settings, std::span<const SteeringField> fields,
                     WorkMesh<Real>* mesh);

  // From here on a chunk that is fused tells how many tetrahedra the mesh still has, many times a
  // second, on the thread that works on it; not with tetfuse. A chunk takes a second and more, too
  // long for whoever waits for an end.
  void watch(std::function<void(std::uint64_t tets)> watcher);

  // Between two rounds.
  void release_memory();

  // From here on every fusion is noted there, which outlives this.
  void keep_logs(FusionLogs* logs) { logs_ = logs; }

  // The first round puts aside there what the fields are; it outlives this.
  void put_values_aside(OriginalValues<Real>* values) { values_ = values; }

  // Gathers a chunk, for whoever wants to look at it.
  static void gather(const MacroLod<Real>& mesh, std::uint32_t chunk, ChunkGather<Real>* gather,
                     WorkMesh<Real>* out);

 private:
  struct Worker {
    explicit Worker(const WorkMesh<Real>& layout) : mesh(layout) {}
    ChunkGather<Real> gather;
    ChunkScatter<Real> scatter;
    WorkMesh<Real> mesh;
  };
  struct ChunkResult {
    FuseStatistics statistics;
    Vector<InterfaceReport> interface;
    Vector<Vec3<Real>> samples;
    std::uint64_t removed_points = 0;
    std::vector<typename ChunkScatter<Real>::PieceSize> sizes;
  };
  // The round that has begun.
  struct Round {
    RoundSettings settings;
    std::uint64_t quota_left = 0;  // where chunks take it in turn
    std::span<const SteeringField> fields;
    std::uint64_t tets = 0;
    std::vector<std::uint64_t> shares;
    CurveCut next_cut;
    std::unique_ptr<PieceStore> next;
    std::vector<ChunkResult> results;
    std::vector<ChunkCosts> costs;  // of the next chunks
    FacingGrid facing, next_facing;
  };
  FuseStatistics run_whole(const RoundSettings& settings, std::span<const SteeringField> fields,
                           MacroLod<Real>* mesh);
  void begin_round(const RoundSettings& settings, std::span<const SteeringField> fields,
                   std::uint64_t tets);
  void make_whole(MacroLod<Real>* mesh);
  FuseStatistics run_passes(const PassLimits& own, WorkMesh<Real>* mesh, FusionLog* log);
  bool puts_values_aside() const { return values_ != nullptr && round_.settings.is_first; }
  FusionLog* wanted(FusionLog* log) const { return logs_ != nullptr ? log : nullptr; }
  void count_costs(const WorkMesh<Real>& mesh, const ChunkScatter<Real>& scatter);
  std::vector<std::uint64_t> shares_of(const RoundSettings& settings,
                                       const MacroLod<Real>& mesh) const;

  WorkMesh<Real> layout_;
  MemoryBudget* budget_;
  Scratch* scratch_;
  std::vector<std::unique_ptr<Worker>> workers_;
  Round round_;
  std::atomic<std::uint64_t> gone_{0};  // in this round, so far
  std::function<void(std::uint64_t)> watcher_;
  FusionLogs* logs_ = nullptr;
  OriginalValues<Real>* values_ = nullptr;
  std::mutex costs_mutex_;
};

// Working on a chunk takes so many times the bytes of its pieces: these, the mesh made of them,
// what a pass knows of it (beside columns a piece has about 20 bytes a tetrahedron; a pass adds 16
// for the balls, 16 for the corners of its start, some for positions and orders), and the pieces
// that it leaves.
inline constexpr std::uint64_t kCopiesOfChunk = 6;
std::uint64_t chunk_memory(std::uint64_t piece_bytes);

extern template class Rounds<float>;
extern template class Rounds<double>;

}  // namespace tetfusion
