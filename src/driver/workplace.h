// Where a run keeps its mesh: in the memory that it may use, or in its scratch folder, from which a
// run that was killed goes on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/request/options.h"
#include "driver/rounds/memory_plan.h"
#include "io/store/scratch.h"

namespace tetfusion {

class Workplace {
 public:
  // Plans; nothing is made yet. The request outlives this. The run uses fewer threads where its
  // memory is not enough for all (fit_threads). Throws Error(kMemory), saying what would be enough,
  // where it may use less than one thread needs with the mesh on disk.
  Workplace(const SimplifyRequest& request, const MeshDescription& mesh,
            const SteeringBytes& steering, const ReaderNeeds& reader, const RunContext& context);

  const MemoryNeeds& needs() const { return needs_; }
  MemoryBudget* budget() const { return budget_.get(); }
  bool on_disk() const { return on_disk_; }

  // Makes the scratch. Returns what an earlier run has left, where this one is to go on from it; it
  // is on disk then, even if the mesh would fit into memory. With `to_memory` nobody comes back for
  // what a run has left, so nothing is committed, and only a folder that was asked for is made.
  // Throws Error(kMemory), Error(kUsage) where there is no folder for a mesh that does not fit;
  // what disk_scratch() throws.
  std::optional<Checkpoint> open(const MeshDescription& mesh, bool to_memory);
  // Instead of open(), for a plan: throws the same, as far as that can be told without making
  // anything. on_disk() is then what it would be.
  void check_place(const MeshDescription& mesh);
  Scratch* scratch() const { return scratch_.get(); }  // null before open()
  std::uint64_t disk_bytes() const { return on_disk_ ? scratch_->peak_bytes() : 0; }  // at most

  // Should a run commit what it has done? From then on, or when it goes on from what an earlier one
  // has committed, there is something to resume.
  bool keeps_work() const { return on_disk_ && keeps_work_; }
  void commit(const std::string& generation, std::span<const std::byte> state);

  // The run is done: nothing is left.
  void remove();
  // The run has failed, and all stores of the scratch are gone. Throws the error, for which the
  // caller has a handler; where there is something to resume with a hint how, else nothing is left.
  [[noreturn]] void give_up(const Error& error);

 private:
  // In memory or on disk? Returns whether the run is to go on from what lies in the folder.
  bool choose_place(bool to_memory);
  ScratchOptions scratch_options(const MeshDescription& mesh) const;

  const SimplifyRequest& request_;
  MemoryNeeds needs_;
  std::unique_ptr<MemoryBudget> budget_;
  bool on_disk_ = false;
  bool keeps_work_ = false;
  bool resumable_ = false;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace tetfusion
