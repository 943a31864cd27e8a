// The fusions of a run, where the mesh is kept too, until they are taken backwards.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/store/scratch.h"
#include "mesh/fusion_log.h"

namespace tetfusion {

// The chunks' fusions of a round do not know each other, so they are taken in turns, by shares of
// what each chunk has deleted: wherever one stops, all have been undone as far as one another. Each
// log is kept in slices of these shares, so that only one slice of all chunks has to be in memory.
class FusionLogs {
 public:
  // About as many bytes of all logs are in memory when they are taken.
  static constexpr std::uint64_t kSliceBytes = std::uint64_t{16} << 20;

  // A log takes about so many bytes for each tetrahedron deleted. The scratch outlives this.
  FusionLogs(Scratch* scratch, std::uint64_t bytes_per_tet);

  // A round over so many tetrahedra; one that has not ended is forgotten.
  void begin(std::uint64_t tets);
  // Each chunk once, from any thread.
  void add(std::uint32_t chunk, const FusionLog& log);
  void end();

  // So that the run can be gone on with: what rounds there are is kept, and resume() takes it up
  // again, before the first round; `slices`, which keep() returns, are those of each.
  std::vector<std::uint32_t> keep();
  void resume(std::span<const std::uint32_t> slices, Checkpoint* from);

  // All fusions of all rounds, the last round first; rounds are counted from 1. They are gone then.
  // The same for any number of slices.
  using Take =
      std::function<void(const FusionRecord& record, std::uint32_t round, std::uint32_t chunk)>;
  void take_backwards(const Take& take);

 private:
  struct Round {
    std::unique_ptr<PieceStore> store;
    std::uint32_t slices = 1;
  };
  static std::string name_of(std::size_t round);  // counted from 1
  void take_slice(std::uint32_t slice, const Take& take) const;

  Scratch* scratch_;
  std::uint64_t bytes_per_tet_;
  Round current_;
  std::vector<Round> rounds_;
  std::size_t kept_ = 0;  // of these
};

}  // namespace tetfusion
